//! Generic terms for the search for dependencies.

use physics::resources::Resources;
use physics::terms::{Driver, Factor, GenericTerm, Law, MOST_DRIVERS, Product};

/// The same terms with laws that are nowhere constant. A law has no influence beyond its range, where a point of the search may lie; which
/// variables a term connects follows from its port, its drivers and its lag alone.
pub fn without_ranges(resources: &Resources) -> Resources {
    let terms = resources.terms.iter().map(|term| GenericTerm { law: without_range(&term.law), ..*term });
    Resources { terms: terms.collect(), load: resources.load.clone() }
}

/// A product of the drivers of a law, of about its size where they have their nominal values.
fn without_range(law: &Law) -> Law {
    let ends: Vec<(Driver, (f64, f64))> = law.ranges().collect();
    let size = |driver: Driver| {
        let finite =
            ends.iter().filter(|(own, _)| *own == driver).flat_map(|(_, (least, most))| [*least, *most]);
        finite.filter(|x| x.is_finite()).fold(driver.nominal(), |size, x| size.max(x.abs()))
    };
    let mut drivers = law.drivers();
    let factors: [Option<Factor>; MOST_DRIVERS] = std::array::from_fn(|_| {
        let driver = drivers.next()?;
        Some(Factor { driver, offset: 0.0, reference: size(driver), exponent: 1.0, range: Factor::UNLIMITED })
    });
    Law::Product(Product { coefficient: law.span(), factors })
}

#[cfg(test)]
mod tests {
    use crate::dependencies::Dependencies;
    use crate::preset::StartValues;
    use physics::model::ModelType;
    use physics::models::ALL;
    use physics::resources::Resources;
    use physics::terms::{Driver, Factor, GenericTerm, Grid, Lag, Law, Port, Product, Table};

    fn declared(kind: &ModelType, term: GenericTerm) -> Dependencies {
        Dependencies::of(kind, &Resources::of_terms(&[term]), &StartValues::default())
    }

    /// Wherever the range of a law lies, and whatever its form, a term has the dependencies of a law without a range: of the outputs and of the
    /// derivatives, on the driver or on the state of its lag.
    #[test]
    fn the_range_of_a_law_does_not_decide_what_it_connects() {
        let kind = ALL.iter().find(|kind| (kind.declaration)().name == "AnnulusCooledMotor").unwrap();
        let power = |range| {
            let factor =
                Factor { driver: Driver::Speed, offset: 0.0, reference: 100.0, exponent: 1.0, range };
            Law::Product(Product { coefficient: 0.01, factors: [Some(factor), None, None] })
        };
        let late = Some(Lag { driver: Driver::Speed, tau: 90.0, difference: false });
        for (port, lag) in [(Port::TorqueConstant, late), (Port::DragTorque, None)] {
            let of = |law: Law| declared(kind, GenericTerm { port, law, lag });
            let whole = of(power(Factor::UNLIMITED));
            let table = Law::Table(Table::new(Driver::Speed, &[3.0, 3.1], &[0.01, 0.02]).unwrap());
            for law in [table, power((7e3, 8e3))] {
                let own = of(law);
                let all = |found: &Dependencies| [found.outputs.clone(), found.rates.clone()].concat();
                for (whole, own) in all(&whole).iter().zip(all(&own)) {
                    let lost: Vec<_> = whole.on.iter().filter(|k| !own.on.contains(k)).collect();
                    assert!(lost.is_empty(), "{port:?} {lag:?} {law:?}: {} lost {lost:?}", own.entry);
                }
            }
        }
        let both = Grid::new(
            [Driver::Speed, Driver::Current],
            [&[1e-3, 2e-3], &[1e-3, 2e-3]],
            &[vec![0.0, 0.1], vec![0.1, 0.3]],
        );
        let own = declared(kind, GenericTerm::new(Port::WindingHeat, Law::Grid(both.unwrap())));
        let plain = Dependencies::of(kind, &Resources::default(), &StartValues::default());
        assert_ne!(own.rates, plain.rates);
    }
}
