//! Doubts about the sizes of machines: numbers that were given in another unit than millimetres.

use glam::DVec3;
use settings::Settings;

use super::report::CheckReport;

/// The longest edge of the smallest powder-bed machines is longer, mm.
const SMALLEST_EDGE_MM: f64 = 80.0;
/// The longest edge of the largest powder-bed machines is shorter, mm.
const LARGEST_EDGE_MM: f64 = 3000.0;
/// Layers of powder are thinner, mm.
const THICKEST_LAYER_MM: f64 = 0.5;
/// Millimetres of an inch.
const MM_PER_INCH: f64 = 25.4;

/// Warns of sizes that are probably not in millimetres.
pub fn check_machines(settings: &Settings, report: &mut CheckReport) {
    for (name, profile) in &settings.profiles {
        if let Some(doubt) = volume_doubt(profile.space.volume_mm) {
            report.add_warning(&format!("volume of {name}"), doubt, "give volume_mm in millimetres");
        }
        let layer_mm = profile.space.layer_mm;
        if layer_mm > THICKEST_LAYER_MM {
            let text = format!("layers of {layer_mm} mm are thicker than any of powder: is that in micrometres?");
            report.add_warning(&format!("layer of {name}"), text, "give layer_mm in millimetres: 0.1");
        }
    }
}

/// Why a build volume is probably not in millimetres; `None` = it may be.
pub fn volume_doubt(volume_mm: DVec3) -> Option<String> {
    let longest = volume_mm.max_element();
    let given = |factor: f64| {
        let DVec3 { x, y, z } = volume_mm * factor;
        format!("{x:.0} x {y:.0} x {z:.0} mm")
    };
    match longest {
        short if short < SMALLEST_EDGE_MM => Some(format!(
            "{} is smaller than any machine: are these centimetres ({}) or inches ({})?",
            given(1.0),
            given(10.0),
            given(MM_PER_INCH)
        )),
        long if long > LARGEST_EDGE_MM => Some(format!(
            "{} is larger than any machine: are these tenths of a millimetre ({})?",
            given(1.0),
            given(0.1)
        )),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centimetres_and_inches_are_doubted_and_machines_from_small_to_large_are_not() {
        let inches = volume_doubt(DVec3::new(15.0, 11.2, 15.0)).unwrap();
        assert!(inches.contains("centimetres (150 x 112 x 150 mm) or inches (381 x 284 x 381 mm)"), "{inches}");
        assert!(volume_doubt(DVec3::new(38.0, 28.4, 38.0)).unwrap().contains("(380 x 284 x 380 mm)"));
        assert!(volume_doubt(DVec3::new(3800.0, 2840.0, 3800.0)).unwrap().contains("(380 x 284 x 380 mm)"));
        for machine in [[90.0, 110.0, 130.0], [165.0, 165.0, 300.0], [700.0, 380.0, 580.0], [1000.0, 600.0, 500.0]] {
            assert_eq!(volume_doubt(DVec3::from_array(machine)), None, "{machine:?}");
        }
    }
}
