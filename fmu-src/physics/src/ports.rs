//! List of the ports. `effects/ports.rs` generates trait, sums and derivatives from it, and `terms/driver.rs` the ports of terms.

/// Passes the list of the ports to the macro `$then`, with the tokens that follow its name. A line of the list is
///
/// ```text
/// [Port as Term "name" Unit of Driver] rule method [D: Number] (arguments) -> result, derivative [method];
/// ```
///
/// `sum`, `factor`, `chain` (each effect gets the result of the one before as first argument) and `least` combine the effects. A
/// method without a port belongs to the port before it. A derivative is with respect to the first argument. `as` names the port of
/// terms that are data ([`terms::Port`](crate::terms::Port)): name in files, unit of a value, and the driver that is evaluated within a
/// step; the others are constant over a step, except at ports that get all drivers.
macro_rules! ports {
    ($then:ident $($with:tt)*) => { $then! { ($($with)*)
        /// A torque against the motion at speed `w`, rad/s: N.m, with the sign of `w`. Its power is friction heat: in
        /// the housing, where a model has a rotor node partly in the rotor.
        [DragTorque] sum drag_torque [D: Number] (w: D) -> D, derivative [drag_torque_slope];
        /// The part of [`drag_torque`](Effect::drag_torque) that arises in the iron, N.m.
        [] sum iron_drag [] (w: f64) -> f64, derivative [];
        /// A torque against the motion that follows `drivers`, with `x` in place of the driver `live`: N.m, as
        /// [`drag_torque`](Effect::drag_torque).
        [DrivenDrag as DragTorque "drag_torque" NewtonMetre of Speed]
            sum driven_drag [D: Number] (x: D, live: Driver, drivers: &Drivers) -> D,
            derivative [driven_drag_slope];
        /// A torque against the motion at speed `w`, rad/s, with the magnets at `t`, K: N.m, as [`drag_torque`](Effect::drag_torque).
        [WarmDrag] sum warm_drag [D: Number] (w: D, t: f64) -> D, derivative [warm_drag_slope];
        /// A torque against the motion per newton metre of shaft torque on the load: with the sign of `w`
        /// times that of the load's torque, approximately `tau`, N.m. Its power is friction heat, too.
        [LoadDrag] sum load_drag [D: Number] (w: D, tau: f64) -> D, derivative [load_drag_slope];
        /// Voltage drop between terminals and winding at current `i`, A: V, with the sign of `i`. Its power heats
        /// the winding.
        [TerminalVoltage] sum terminal_voltage [D: Number] (i: D) -> D, derivative [terminal_voltage_slope];
        /// Voltage drop between terminals and winding that follows `drivers`, with `x` in place of the driver `live`: V, as
        /// [`terminal_voltage`](Effect::terminal_voltage).
        [DrivenVoltage as TerminalVoltage "terminal_voltage" Volt of Current]
            sum driven_voltage [D: Number] (x: D, live: Driver, drivers: &Drivers) -> D,
            derivative [driven_voltage_slope];
        /// Voltage in series with the winding that follows `drivers`, with `x` in place of the driver `live`: V, for both signs of the
        /// current the same. Its power, which may be negative, heats the winding.
        [SeriesVoltage as SeriesVoltage "series_voltage" Volt of Current]
            sum series_voltage [D: Number] (x: D, live: Driver, drivers: &Drivers) -> D,
            derivative [series_voltage_slope];
        /// Voltage drop of the drive's bridge at current `i`, A (drive_mode pwm): V, with the sign of `i`. Its power heats
        /// ambient.
        [Bridge] sum bridge_voltage [D: Number] (i: D) -> D, derivative [bridge_voltage_slope];
        /// Reduction of the motor voltage at current `i`, A, with the supply voltage `supply`, V; the supply power is lower accordingly
        /// (drive_mode pwm): V, with the sign of `i`. No heat.
        [] sum missed_voltage [D: Number] (i: D, supply: f64) -> D, derivative [missed_voltage_slope];
        /// Mean square of the current's ripple, A2 (drive_mode pwm), which heats the winding.
        [Ripple] sum ripple_square [] (duty: f64, supply: f64, inductance: f64) -> f64, derivative [];
        /// Multiplies the winding's resistance, with `x` in place of the driver `live`; positive.
        [WindingResistance as WindingResistance "winding_resistance" One]
            factor winding_resistance [D: Number] (x: D, live: Driver, drivers: &Drivers) -> D,
            derivative [winding_resistance_slope];
        /// Multiplies the torque constant at `time`, s. As a function of time it changes in steps at
        /// [`next_event`](Effect::next_event) only.
        [TorqueConstant] factor torque_constant [] (time: f64) -> f64, derivative [];
        /// The first time after `time` at which a port is discontinuous, s; infinite if there is none.
        [] least next_event [] (time: f64) -> f64, derivative [];
        /// Multiplies the torque constant, with `x` in place of the driver `live`; positive.
        [DrivenTorqueConstant as TorqueConstant "torque_constant" One]
            factor driven_torque_constant [D: Number] (x: D, live: Driver, drivers: &Drivers) -> D,
            derivative [driven_torque_constant_slope];
        /// Additional heat in the winding, W, besides its current's.
        [WindingHeat as WindingHeat "winding_heat" Watt] sum winding_heat [] () -> f64, derivative [];
        /// Heat in the housing at `t_h`, K, taken from ambient, W.
        [HousingHeat as HousingHeat "housing_heat" Watt of HousingTemperature]
            sum housing_heat [D: Number] (t_h: D) -> D, derivative [housing_heat_slope];
        /// A stator between winding and housing: its resistance to the housing, in a network added to thermal.R_sh, and its heat capacity.
        /// Constant: no argument.
        [Stator] sum stator [] () -> Stator, derivative [];
        /// Multiplies the thermal resistance thermal.R_wh with the winding at `t_w`, K; positive. This is the resistance from winding to
        /// housing, and where the stator is a node (a network, effect.stator_node) from winding to stator.
        [WindingHousingResistance as WindingHousingResistance "winding_housing_resistance" One of WindingTemperature]
            factor winding_housing_resistance [D: Number] (t_w: D) -> D,
            derivative [winding_housing_resistance_slope];
        /// Additional conductances to ambient, W/K, at the fan's `flow`, 0 to 1.
        [AmbientConductance] sum ambient_conductance [] (flow: f64) -> PerNode, derivative [];
        /// Heat flow from the housing at `t_h`, K, to ambient at `t_a` that no conductance describes, W.
        [HousingToAmbient as HousingAmbientConductance "housing_ambient_conductance" WattPerKelvin
            of HousingTemperature]
            sum housing_to_ambient [D: Number] (t_h: D, t_a: f64) -> D,
            derivative [housing_to_ambient_slope];
        /// Additional heat flow to still air at the temperature rise `rise`, K, divided by the conductance of still air, K.
        [StillAir] sum still_air [D: Number] (rise: D) -> D, derivative [still_air_slope];
        /// Multiplies every heat capacity; positive.
        [HeatCapacity as HeatCapacity "heat_capacity" One] factor heat_capacity [] () -> f64, derivative [];
        /// The effective fan command for the command `n`, 0 to 1.
        [FanFlow as FanFlow "fan_flow" One of FanCommand] chain fan_flow [] (n: f64) -> f64, derivative [];
        /// Drift rate of the true ambient temperature relative to the indicated one, K/s; they agree at time 0.
        [AmbientSensor as AmbientSensor "ambient_sensor" Kelvin] sum ambient_sensor [] () -> f64, derivative [];
        /// Difference of the true ambient temperature to the indicated one, without drift, K.
        [] sum ambient_offset [] () -> f64, derivative [];
        /// Time constants of the sensors of winding and housing, s.
        [SensorLag] sum sensor_lag [] () -> PerNode, derivative [];
        /// Indicated winding temperature at the temperature `t` (lag included) with ambient at `t_a`, K.
        [WindingSensor as WindingSensor "winding_sensor" Kelvin]
            chain winding_sensor [] (t: f64, t_a: f64) -> f64, derivative [];
        /// Indicated housing temperature at the temperature `t` (lag included) with ambient at `t_a`, K.
        [HousingSensor as HousingSensor "housing_sensor" Kelvin]
            chain housing_sensor [] (t: f64, t_a: f64) -> f64, derivative [];
        /// Indicated torque at the shaft torque `tau`, N.m, on the load.
        [TorqueSensor as TorqueSensor "torque_sensor" NewtonMetre]
            chain torque_sensor [] (tau: f64) -> f64, derivative [];
        /// Fraction of the input electrical_power that heats ambient instead of the winding.
        [DriveLoss] sum drive_loss [] () -> f64, derivative [];
        /// Fraction of the electrical_power that reaches the motor (drive_mode power) and heats the stator instead of the winding.
        [StatorLoss] sum stator_loss [] () -> f64, derivative [];
        /// Torque of the load at the imposed speed `w`, rad/s, whose power is a part of electrical_power (drive_mode power):
        /// N.m, with the sign of `w`.
        [PowerModeLoad] sum power_mode_torque [] (w: f64) -> f64, derivative [];
    } };
}
pub(crate) use ports;
