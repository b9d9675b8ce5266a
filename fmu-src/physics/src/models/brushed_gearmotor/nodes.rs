//! Thermal nodes of the gearmotor: list of the nodes, heat capacities, heat paths and heat sources.
//!
//! A further node is a line of the list ([`nodes!`]), its heat capacity (`capacity`), its heat paths (`paths`) and its heat source (`heats`).
//! States, initial values, outputs, integrator, energy balance, saved states and Model Exchange follow.

use crate::components::enclosure::{Enclosure, LEAST_CAPACITY};
use crate::components::initial::{first_outside, temperature};
use crate::components::validity::Limits;
use crate::effects::{Effects, PerNode};
use crate::ledger::{Account, MOST_NODES};
use crate::solver::split::{self, Fast};
use declare::{Elements, Unit, Variable, states, variables};
use nalgebra::SVector;

/// Passes the list of the nodes to a macro: what each node is, its index, and the name of its temperature; value reference of the output;
/// name and value reference of the state (that of the derivative is 100 higher), with the nominal value of the derivative; value reference
/// of the initial value. `near` are measured temperatures that a run can start at, the nearest first, if that of the node is not measured.
/// `optional`: below the least heat capacity in this field of [`Enclosure`], which has this name, the node is part of another one.
macro_rules! nodes {
    ($then:ident) => {
        $then! {
            /// the winding
            WINDING winding_temperature {
                output 25, state "state.winding_temperature" 704, rate 1.0, initial 0,
                near "housing_temperature" "box_temperature"
            }
            /// the housing, with magnets, and with the gear without thermal.C_g
            HOUSING housing_temperature {
                output 26, state "state.housing_temperature" 705, rate 0.1, initial 1,
                near "winding_temperature" "box_temperature"
            }
            /// the box, air and walls
            BOX box_temperature {
                output 27, state "state.box_temperature" 706, rate 0.1, initial 2,
                near "housing_temperature" "winding_temperature"
            }
            /// the gear
            GEAR gear_temperature {
                optional C_g "thermal.C_g" part_of HOUSING " the housing",
                output 59, state "state.gear_temperature" 712, rate 0.1, initial 6,
                near "housing_temperature" "winding_temperature" "box_temperature"
            }
        }
    };
}
pub(super) use nodes;

macro_rules! declare_nodes {
    ($(#[doc = $of:literal] $node:ident $name:ident {
        $(optional $capacity:ident $switch:literal part_of $whole:ident $of_whole:literal,)?
        output $output:literal, state $state:literal $reference:literal, rate $rate:literal, initial $initial:literal,
        near $($near:literal)*
    })*) => {
        #[allow(clippy::upper_case_acronyms)]
        enum Index { $($node),* }
        $(pub(super) const $node: usize = Index::$node as usize;)*

        // Nominal derivatives, with the default motor at 12 V and 1 A: 12 V / L for the current, torque of 1 A over the rotor inertia at
        // the output shaft for its speed, R (1 A)^2 over the heat capacity for temperatures, and powers for the energies.
        states! {
            /// The states of the gearmotor, in the order of `Step::rates`.
            pub const LIST = {
                /// Mean current in the winding
                "state.current" = declare::State::new(701, 801, Unit::Ampere).nominal(1.0, 7e3),
                /// Speed of the output shaft
                "state.shaft_speed" = declare::State::new(702, 802, Unit::RadianPerSecond).nominal(10.0, 10.0),
                /// Angle of the output shaft, initial.shaft_angle at the start
                "state.shaft_angle" = declare::State::new(703, 803, Unit::Radian).unbounded().nominal(100.0, 10.0),
                $(#[doc = concat!(" Temperature of", $of $(, "; constant without ", $switch)?)]
                $state = declare::State::new($reference, $reference + 100, Unit::Kelvin).nominal(300.0, $rate),)*
                /// Energy from the supply since the start
                "state.energy_supply" = declare::State::new(707, 807, Unit::Joule).unbounded().nominal(1000.0, 10.0),
                /// Mechanical energy to the load since the start
                "state.energy_shaft" = declare::State::new(708, 808, Unit::Joule).unbounded().nominal(1000.0, 10.0),
                /// Heat to ambient since the start
                "state.energy_heat_to_ambient" = declare::State::new(709, 809, Unit::Joule).unbounded().nominal(1000.0, 10.0),
                /// Electrical losses in the winding since the start
                "state.work_electrical" = declare::State::new(710, 810, Unit::Joule).unbounded().nominal(100.0, 10.0),
                /// Friction losses since the start
                "state.work_friction" = declare::State::new(711, 811, Unit::Joule).unbounded().nominal(100.0, 1.0),
                /// Lagged driver of each term of resources/effects.json, divided by a typical value of the driver; constant without a lag
                "state.term_lag" = declare::State::new(713, 813, Unit::One).elements(Elements::Fixed(3)),
            }
        }

        variables! {
            /// Initial state.
            pub struct Initial {
                $(#[doc = concat!(" Initial temperature of", $of, $(" (not without ", $switch, ")",)? "; 0 K = ambient temperature")]
                $name: f64 = Variable::initial_temperature($initial, &[$($near),*]),)*
                /// Initial mean current in the winding
                current: f64 = Variable::fixed(3, 0.0, Unit::Ampere, -1e4, 1e4),
                /// Initial speed of the output shaft
                shaft_speed: f64 = Variable::fixed(4, 0.0, Unit::RadianPerSecond, -1e5, 1e5).nominal(10.0),
                /// Initial angle of the output shaft
                shaft_angle: f64 = Variable::fixed(5, 0.0, Unit::Radian, -1e9, 1e9).nominal(100.0),
            }
        }

        /// Names of the initial temperatures.
        const INITIAL: &[&str] = &[$(concat!("initial.", stringify!($name))),*];

        impl Initial {
            /// Temperatures of the nodes, K.
            fn nodes(&self) -> [f64; NODES] {
                [$(self.$name),*]
            }
        }

        impl Network<'_> {
            /// The node that has the temperature of this one: itself, or, without its heat capacity, the node that it is part of.
            #[inline]
            fn place(&self, node: usize) -> usize {
                match node {
                    $($($node if self.thermal.$capacity < LEAST_CAPACITY => $whole,)?)*
                    _ => node,
                }
            }
        }
    };
}
nodes!(declare_nodes);

/// Number of thermal nodes.
pub const NODES: usize = INITIAL.len();
const _: () = assert!(NODES <= MOST_NODES);
// As in `HeatCapacities`.
const _: () = assert!(WINDING == 0 && HOUSING == 1);
/// Temperatures of the nodes, K.
pub type Temperatures = SVector<f64, NODES>;

impl Initial {
    /// Initial values outside the limits of validity, in one sentence.
    pub(super) fn fault(&self, limits: &Limits) -> Option<String> {
        let nodes: [_; NODES] = std::array::from_fn(|k| (INITIAL[k], self.nodes()[k]));
        let [winding, others @ ..] = nodes;
        first_outside(limits, winding, &others)
    }

    /// The initial state; nodes without an initial value start at `ambient`, K.
    pub(super) fn state<const E: usize>(&self, ambient: f64) -> split::State<NODES, E> {
        split::State {
            x: Fast::new(self.current, self.shaft_speed),
            angle: self.shaft_angle,
            temperature: self.nodes().map(|node| temperature(node, ambient)).into(),
            ..split::State::default()
        }
    }
}

/// Heat flow from one node to another or to ambient.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path {
    /// The node that it leaves.
    pub from: usize,
    /// The node that it reaches; `None`: ambient.
    pub to: Option<usize>,
    /// W.
    pub flow: f64,
    /// Its derivative with respect to the temperature of `from`, and minus that with respect to the temperature of `to`, W/K.
    pub slopes: [f64; 2],
}

/// The account in the energy balance of a node, or of ambient.
pub(super) fn account(node: Option<usize>) -> Account {
    node.map_or(Account::Ambient, Account::Node)
}

/// Losses, in W or J; [`Network::heats`] says which nodes they heat.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Losses {
    /// Losses in the winding, contacts included.
    pub winding: f64,
    /// Friction.
    pub friction: f64,
    /// Losses of the bridge.
    pub bridge: f64,
}

/// Data of the thermal network.
#[derive(Clone, Copy, Debug)]
pub(super) struct Network<'a> {
    /// Heat capacities and conductances.
    pub thermal: &'a Enclosure,
    /// The effects.
    pub effects: &'a Effects,
    /// Conductances of the effects from winding and housing to the box, W/K.
    pub to_box: PerNode,
}

impl Network<'_> {
    /// Heat capacities of the nodes, J/K; that of a node that is part of another is arbitrary, since it receives no heat.
    pub fn capacity(&self) -> Temperatures {
        let thermal = self.thermal;
        let mut capacity = Temperatures::zeros();
        capacity[WINDING] = thermal.C_w;
        capacity[HOUSING] = thermal.C_h;
        capacity[BOX] = thermal.C_b;
        capacity[GEAR] = thermal.C_g;
        Temperatures::from_fn(|node, _| capacity[self.place(node)])
    }

    /// `value` of a node; 0 if it is part of another one.
    #[inline]
    fn own(&self, node: usize, value: f64) -> f64 {
        if self.place(node) == node { value } else { 0.0 }
    }

    /// Temperature of a node, K, or of the one that it is part of.
    #[inline]
    pub fn temperature(&self, node: usize, temperature: &Temperatures) -> f64 {
        temperature[self.place(node)]
    }

    /// Temperature of a node as an output, K: that of winding and housing is indicated by a sensor.
    #[inline]
    pub fn indicated(&self, node: usize, temperature: &Temperatures) -> f64 {
        let effects = self.effects;
        match node {
            WINDING => effects.winding_sensor(temperature[WINDING], temperature[BOX]),
            HOUSING => effects.housing_sensor(temperature[HOUSING], temperature[BOX]),
            _ => self.temperature(node, temperature),
        }
    }

    /// Heat of the losses by node, and the rest, which goes to ambient; W or J as the losses.
    #[inline]
    pub fn heats(&self, losses: &Losses) -> (Temperatures, f64) {
        let in_gear = self.own(GEAR, self.thermal.friction_to_gear) * losses.friction;
        let mut heat = Temperatures::zeros();
        heat[WINDING] = losses.winding;
        heat[HOUSING] = losses.friction - in_gear;
        heat[GEAR] = in_gear;
        (heat, losses.bridge)
    }

    /// The heat paths with ambient at `ambient`, K.
    // Inlined, so that derivatives are computed only where they are used.
    #[inline(always)]
    pub fn paths(&self, ambient: f64, temperature: &Temperatures) -> impl IntoIterator<Item = Path> + use<> {
        let Network { thermal, effects, to_box } = *self;
        let (t_w, t_h, t_b) = (temperature[WINDING], temperature[HOUSING], temperature[BOX]);
        let path = |from, to, flow, slopes| Path { from, to, flow, slopes };
        let conductance = |from: usize, to: Option<usize>, g: f64| {
            path(from, to, g * (temperature[from] - to.map_or(ambient, |to| temperature[to])), [g, g])
        };
        let factor = effects.winding_housing_resistance(t_w);
        let share = 1.0 / factor;
        let cold = share / thermal.R_wh;
        let hot = cold - cold * (t_w - t_h) * effects.winding_housing_resistance_slope(t_w) * share;
        let to_box_of_housing = thermal.G_hb + to_box.housing;
        // Net radiation is antisymmetric in the two temperatures, so its second derivative follows by exchanging them; that of a term over
        // the housing's temperature is approximate, and of the Jacobian only.
        let [flow, to_hot, to_cold] = [
            effects.housing_to_ambient(t_h, t_b),
            effects.housing_to_ambient_slope(t_h, t_b),
            effects.housing_to_ambient_slope(t_b, t_h),
        ];
        [
            path(WINDING, Some(HOUSING), (t_w - t_h) / (thermal.R_wh * factor), [hot, cold]),
            conductance(WINDING, Some(BOX), to_box.winding),
            path(
                HOUSING,
                Some(BOX),
                to_box_of_housing * (t_h - t_b) + flow,
                [to_box_of_housing + to_hot, to_box_of_housing + to_cold],
            ),
            conductance(BOX, None, thermal.G_ba),
            conductance(GEAR, Some(HOUSING), self.own(GEAR, 1.0 / thermal.R_gh)),
            path(WINDING, None, -effects.winding_heat(), [0.0; 2]),
            path(HOUSING, None, -effects.housing_heat(t_h), [-effects.housing_heat_slope(t_h), 0.0]),
        ]
    }
}
