//! The box to fill, and the margins along its walls.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// The printable box of a machine, with its lower front left corner at the origin. Wall margins are already subtracted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BuildVolume {
    /// Edge lengths, mm; z is the greatest build height.
    pub size_mm: DVec3,
}

/// The space that is kept free along the walls, above the floor and below the ceiling of a machine, mm.
///
/// ```
/// use glam::DVec3;
/// use nester::VolumeMargins;
///
/// let margins = VolumeMargins { wall_mm: 5.0, floor_mm: 3.0, lid_mm: 1.0 };
/// assert_eq!(margins.usable_volume(DVec3::splat(100.0)).size_mm, DVec3::new(90.0, 90.0, 96.0));
/// assert_eq!(margins.origin_mm(), DVec3::new(5.0, 5.0, 3.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct VolumeMargins {
    /// Along the four walls.
    pub wall_mm: f64,
    /// Above the floor.
    pub floor_mm: f64,
    /// Below the ceiling.
    pub lid_mm: f64,
}

impl From<DVec3> for VolumeMargins {
    /// Wall, floor and ceiling margin in this order, mm.
    fn from(margins: DVec3) -> Self {
        Self { wall_mm: margins.x, floor_mm: margins.y, lid_mm: margins.z }
    }
}

impl VolumeMargins {
    /// The part of a printable box that may be filled, mm.
    pub fn usable_volume(&self, volume_mm: DVec3) -> BuildVolume {
        let taken = DVec3::new(2.0 * self.wall_mm, 2.0 * self.wall_mm, self.floor_mm + self.lid_mm);
        BuildVolume { size_mm: volume_mm - taken }
    }

    /// Wall, floor and ceiling margin in this order, mm.
    pub fn as_dvec3(self) -> DVec3 {
        DVec3::new(self.wall_mm, self.floor_mm, self.lid_mm)
    }

    /// Position of the usable volume's lower front left corner in the machine's frame, mm.
    pub fn origin_mm(&self) -> DVec3 {
        DVec3::new(self.wall_mm, self.wall_mm, self.floor_mm)
    }
}
