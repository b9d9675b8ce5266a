//! The attributes of the root, the default experiment, log categories and annotations.

use super::*;

pub(super) fn check(model: &Model, out: &mut Findings) {
    let place = model.place(model.root);
    let token = match model.version {
        FmiVersion::V2 => "guid",
        FmiVersion::V3 => "instantiationToken",
    };
    if model.root.attribute(token).is_some_and(|t| t.trim().is_empty()) {
        out.add(&place, rules::token_empty(token));
    }
    if model.root.attribute("modelName").is_some_and(|t| t.trim().is_empty()) {
        out.add(&place, rules::model_name_empty());
    }
    if let Some(date) = model.root.attribute("generationDateAndTime").filter(|d| Type::DateTime.accepts(d))
        && !(date.len() == 20 && date.ends_with('Z'))
    {
        out.add(&place, rules::date_form(short(date)));
    }
    check_experiment(model, out);
    for list in children(model.root, "LogCategories") {
        unique_names(model, list, "Category", "log category", &rules::LOG_CATEGORY_REPEATED, out);
    }
    for list in children(model.root, "VendorAnnotations") {
        unique_names(model, list, "Tool", "tool of the vendor annotations", &rules::ANNOTATION_REPEATED, out);
    }
}

fn unique_names(
    model: &Model,
    list: Node<'_, '_>,
    element: &str,
    what: &str,
    rule: &'static Rule,
    out: &mut Findings,
) {
    let mut seen = HashSet::new();
    for node in list.children().filter(|c| c.has_tag_name(element)) {
        if let Some(name) = node.attribute("name").filter(|n| !seen.insert(*n)) {
            let message = format!("The {what} \"{}\" is defined more than once", short(name));
            out.add(model.place(node), rule.says(message));
        }
    }
}

fn check_experiment(model: &Model, out: &mut Findings) {
    for node in children(model.root, "DefaultExperiment") {
        let mut complain =
            |message: String| out.add(model.place(node), rules::DEFAULT_EXPERIMENT.says(message));
        for name in ["startTime", "stopTime", "tolerance", "stepSize"] {
            if let Some(value) = double(node, name).filter(|v| !v.is_finite()) {
                complain(format!("{name} of the default experiment is {value}, not a finite number"));
            }
        }
        for name in ["tolerance", "stepSize"] {
            if let Some(value) = double(node, name).filter(|v| *v <= 0.0) {
                complain(format!("{name} of the default experiment is {value} and must be greater than 0"));
            }
        }
        let start = double(node, "startTime").unwrap_or(0.0);
        if let Some(stop) = double(node, "stopTime").filter(|stop| *stop <= start) {
            complain(format!("stopTime {stop} of the default experiment is not after its startTime {start}"));
        } else if let (Some(stop), Some(step)) = (double(node, "stopTime"), double(node, "stepSize"))
            && step > stop - start
            && step.is_finite()
        {
            out.add(model.place(node), rules::experiment_step_long(step, start, stop));
        }
    }
}
