//! What no layout can beat.

use super::Instance;

/// A height that no layout with all copies of the instance can beat, mm.
pub fn lower_bound_mm(instance: &Instance) -> f64 {
    let base = instance.volume().size_mm;
    let volume_mm3: f64 = instance.items().iter().map(|i| f64::from(i.copies) * i.mesh.volume_mm3()).sum();
    volume_mm3 / (base.x * base.y)
}
