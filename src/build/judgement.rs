//! What the independent judge says of bodies on a machine: walls, clearance, keep-out boxes, layers, and whether they come
//! apart.

use nester::{Body, Interlock, LayerAreas, Proof, Separability, TakenApart};

use super::Machine;

/// What was found out about bodies on a machine.
#[derive(Debug)]
pub struct Judgement {
    /// Walls, clearance, containment and keep-out boxes; in the build volume's frame.
    pub proof: Proof,
    /// What is filled in each layer, where the machine has a cap on it and nothing stands outside.
    pub layers: Option<LayerAreas>,
    /// How they come apart; `None` where locked parts are allowed and nobody looked.
    pub apart: Option<TakenApart>,
    interlock: Interlock,
}

impl Machine {
    /// Judges bodies in the build volume's frame.
    pub fn judge(&self, bodies: &[Body]) -> Judgement {
        let room_mm = self.build_volume().size_mm;
        let proof = nester::prove_with(bodies, room_mm, self.clearance_z_extra_mm, &self.keep_out_in_volume());
        // What stands outside is told anyway, and layers without end are not counted.
        let is_counted = self.layer_cap.capped_mm2().is_some() && proof.outside.is_empty();
        let placed = bodies.iter().map(|body| (&*body.mesh, body.pose));
        let layers = is_counted.then(|| LayerAreas::of(placed, self.layer_cap));
        let apart = Separability::apart(self.interlock, bodies);
        Judgement { proof, layers, apart, interlock: self.interlock }
    }
}

impl Judgement {
    /// Whether nothing was found.
    pub fn is_proved(&self) -> bool {
        let is_locked = self.interlock == Interlock::Forbid && !self.locked().is_empty();
        self.proof.is_proved() && !is_locked && self.layer_fault().is_none()
    }

    /// Bodies that cannot be drawn out.
    pub fn locked(&self) -> &[usize] {
        self.apart.as_ref().map_or(&[], |apart| &apart.locked)
    }

    /// The layer that is filled beyond the cap.
    pub fn layer_fault(&self) -> Option<String> {
        self.layers.as_ref().filter(|layers| !layers.keeps_cap()).map(LayerAreas::in_words)
    }

    /// What is wrong with where bodies stand, a line each; `name` gives the name of a body.
    pub fn placement_faults(&self, name: impl Fn(usize) -> String) -> Vec<String> {
        let proof = &self.proof;
        let close = (proof.too_close.iter()).map(|pair| {
            let (first, second) = (name(pair.first), name(pair.second));
            format!("{first} and {second} are {:.6} mm apart instead of {} mm", pair.distance_mm, pair.wanted_mm)
        });
        let outside =
            proof.outside.iter().map(|&(i, excess)| format!("{} stands {excess:.6} mm out of the volume", name(i)));
        let inside = proof.inside.iter().map(|&(outer, inner)| format!("{} lies inside {}", name(inner), name(outer)));
        let intruding =
            proof.intruding.iter().map(|&(i, zone)| format!("{} stands in keep-out box {}", name(i), zone + 1));
        close.chain(outside).chain(inside).chain(intruding).collect()
    }
}
