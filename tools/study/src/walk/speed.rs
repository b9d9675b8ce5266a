//! Whether the supply voltage suffices for the speed of the joint.

use super::load::Load;
use crate::StudyError;
use crate::reproduce::significant;
use std::f64::consts::PI;

/// Instants of a stride at which the speed is read.
const INSTANTS: u32 = 400;

impl Load {
    /// A sentence for each activity or cycle whose speed turns the motor faster than it turns without load at the supply voltage.
    ///
    /// # Errors
    /// A gait that does not start.
    pub fn speed_notes(&self) -> Result<Vec<String>, StudyError> {
        let mut notes = Vec::new();
        for part in self.parts() {
            let place = part.words().place;
            let (joint, ratio, supply) = match part.table().filter(|_| place == "cycle") {
                Some((table, _, drive)) => {
                    let peak = table.speeds.iter().fold(0.0, |peak: f64, speed| peak.max(speed.abs()));
                    (peak, drive.ratio, "cycle.supply")
                }
                None => (part.peak_speed()?, part.gear_ratio()?, "supply_voltage"),
            };
            let (voltage, k_t) = (part.get(supply)?, part.get("motor.k_t")?);
            let (needed, no_load) = (joint * ratio, voltage / k_t);
            if needed > no_load {
                let [joint, ratio, needed, no_load, voltage] =
                    [joint, ratio, needed, no_load, voltage].map(significant);
                notes.push(format!(
                    "{}: the peak speed of the {place}, {joint} rad/s, times the ratio {ratio} is {needed} rad/s; without load the motor \
                     reaches {no_load} rad/s at {supply} = {voltage} V, so that the torque error increases near the peak speed",
                    part.source()?
                ));
            }
        }
        notes.dedup();
        Ok(notes)
    }

    /// The supply voltage of the actuator, V, where neither the load nor the preset of the motor gives it.
    ///
    /// # Errors
    /// None with declared names.
    pub fn default_supply(&self) -> Result<Option<f64>, StudyError> {
        let Some(part) = self.parts().into_iter().find(|part| part.words().place == "joint") else {
            return Ok(None);
        };
        let given = part.explicit.contains("supply_voltage")
            || part.derived()?.iter().any(|d| d.name == "supply_voltage");
        Ok(if given { None } else { Some(part.get("supply_voltage")?) })
    }

    /// Angle of the motor over that of the joint.
    fn gear_ratio(&self) -> Result<f64, StudyError> {
        Ok(match self.get("transmission.kind")? {
            1.0 => self.get("transmission.ratio")?,
            _ => 2.0 * PI * self.get("transmission.lever")? / self.get("transmission.lead")?,
        })
    }

    /// Greatest speed of the joint over a stride, rad/s.
    fn peak_speed(&self) -> Result<f64, StudyError> {
        let [.., mut gait] = self.prepared()?;
        gait.start()?;
        let step = 1.0 / gait.get("der(state.stride)")? / f64::from(INSTANTS);
        let mut peak = 0.0_f64;
        for _ in 0..INSTANTS {
            peak = peak.max(gait.get("joint_speed")?.abs());
            gait.step(step)?;
        }
        Ok(peak)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use describe::Preset;

    fn notes(text: &str, sets: &[(&str, &str)]) -> Vec<String> {
        let preset = Preset::load("maxon-eci40-488607").unwrap();
        let sets: Vec<_> = sets.iter().map(|(n, v)| ((*n).to_owned(), (*v).to_owned())).collect();
        Load::parse(text, "gait.toml", Some(&preset), &sets).unwrap().speed_notes().unwrap()
    }

    /// 48 V / 0.091 V.s/rad are 527 rad/s: the knee in walking passes them between the ratios 80 and 100, with 60 V above 100.
    #[test]
    fn a_supply_that_is_too_low_for_the_speed_is_named() {
        const KNEE: &str = "[motor]\ndrive_mode = \"current\"\n[gait]\n\"gait.joint\" = \"knee\"\n";
        assert!(notes(KNEE, &[("transmission.ratio", "80")]).is_empty());
        let found = notes(KNEE, &[("transmission.ratio", "100")]);
        assert!(
            found.len() == 1 && found[0].contains("527.5 rad/s at supply_voltage = 48.00 V"),
            "{found:?}"
        );
        assert!(notes(KNEE, &[("transmission.ratio", "100"), ("supply_voltage", "60")]).is_empty());
        let screw = [("transmission.kind", "ball_screw"), ("transmission.lever", "0.1")];
        assert!(notes(KNEE, &screw)[0].contains("314.2"));
    }

    /// Each activity of a mix has its own speed; rest has none.
    #[test]
    fn the_phases_of_a_mix_are_checked_one_by_one() {
        const MIX: &str = "[mix]\nperiod = \"10 min\"\nphase = [\n{ fraction = 0.5, \"gait.activity\" = \"walk\" },\n\
             { fraction = 0.2, \"gait.activity\" = \"child_walk_very_slow\" },\n{ fraction = 0.3, rest = true },\n]\n\
             [gait]\n\"gait.joint\" = \"knee\"\n[actuator]\n\"transmission.ratio\" = 100\n[motor]\ndrive_mode = \"current\"\n";
        let found = notes(MIX, &[]);
        assert!(found.len() == 1 && found[0].starts_with("Level walking of adults"), "{found:?}");
    }
}
