//! Values for parameters and inputs: component, unit, and errors.
use super::ends::named;
use super::structure::{Component, Place, Setting, Structure};
use super::units::{Affine, conversion, unit_of};
use crate::quantity::{in_unit, number_with_unit};
use crate::{DisplayUnit, Error, ModelDescription, Unit, Value};

/// A setting with its origin.
pub(crate) struct Given {
    pub(crate) setting: Setting,
    /// Given on the command line, not in the file.
    pub(crate) asked: bool,
    pub(crate) used: bool,
}

/// The settings of the system, then those of the caller, which take precedence because they come later.
pub(crate) fn given(structure: &Structure, overrides: &[(String, String)]) -> Vec<Given> {
    let nowhere = Place { file: "".into(), line: 0 };
    let asked = overrides.iter().map(|(name, text)| Setting {
        name: name.clone(),
        text: text.clone(),
        unit: None,
        linear: Affine::IDENTITY,
        place: nowhere.clone(),
    });
    let own = structure.settings.iter().cloned().map(|setting| Given { setting, asked: false, used: false });
    own.chain(asked.map(|setting| Given { setting, asked: true, used: false })).collect()
}

/// The component that a setting `component.variable` belongs to, and the rest of the name.
pub(crate) fn owner<'a>(structure: &Structure, name: &'a str) -> Option<(usize, &'a str)> {
    let rest = |c: &Component| name.strip_prefix(c.name.as_str())?.strip_prefix('.');
    let all = structure.components.iter().enumerate().filter_map(|(i, c)| Some((i, rest(c)?)));
    // Names of SSP may have dots: the longest one counts.
    all.min_by_key(|(_, rest)| rest.len())
}

/// A setting as a value of the variable `name`. `way` leads from a connector of the system, with its unit, inward. A number without unit is
/// in the display unit `shown`, where there is one.
pub(crate) fn value(
    description: &ModelDescription,
    name: &str,
    setting: &Setting,
    way: Option<(Option<&Unit>, Affine)>,
    shown: Option<&DisplayUnit>,
) -> Result<(usize, Value), Error> {
    let variable = description.settable(name)?;
    let place = description.variables.iter().position(|v| v.name == name).unwrap_or(0);
    let inner = unit_of(description, variable);
    let (outer, way) = way.unwrap_or((inner.as_ref(), Affine::IDENTITY));
    let Some(convert) = conversion(setting.unit.as_ref(), outer, variable.relative) else {
        let (inner, unit) = (named(&inner), named(&setting.unit));
        let reason = format!("is in {inner}, its value in {unit}: these cannot be converted");
        return Err(Error::unsupported(&variable.name, reason));
    };
    let beside = setting.linear.then(way);
    let plain = || setting.text.trim().parse().ok().filter(|_: &f64| variable.kind.is_float());
    let number = match (number_with_unit(variable, &setting.text), shown) {
        (Some((number, "")), Some(shown)) => Some((shown.back(number), beside)),
        (None, Some(shown)) => plain().map(|number| (shown.back(number), beside)),
        // The unit in the text is that of the number, whatever the unit of the connector is.
        (Some((number, unit)), _) => {
            let outward = conversion(inner.as_ref(), outer, variable.relative).unwrap_or(Affine::IDENTITY);
            Some((in_unit(description, variable, number, unit)?, outward.then(beside)))
        }
        (None, None) => {
            plain().map(|number| (number, convert.then(beside))).filter(|(_, c)| *c != Affine::IDENTITY)
        }
    };
    let text =
        number.map_or_else(|| setting.text.clone(), |(number, convert)| convert.of(number).to_string());
    Ok((place, description.value_of(variable, &text)?))
}

/// Error of a setting, with its location.
pub(crate) fn setting_error(component: &Component, setting: &Setting, asked: bool, error: Error) -> Error {
    if asked {
        return refused(setting, true, format!("is refused: {error}"));
    }
    setting.place.fault(format!("component {}: {error}", component.name))
}

pub(crate) fn refused(setting: &Setting, asked: bool, reason: String) -> Error {
    if asked {
        return Error::unsupported(format!("setting {} = {}", setting.name, setting.text), reason);
    }
    setting.place.fault(format!("{} {reason}", setting.name))
}
