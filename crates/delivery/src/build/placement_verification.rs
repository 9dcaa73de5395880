//! What the independent proof says of bodies on a machine: walls, clearance, keep-out boxes, layers, and whether they
//! can be taken apart.

use nester::{Disassembly, InterlockRule, LayerAreas, LayoutProof, LayoutProver, PlacedSolid, Separability};

use super::MachineSpec;

/// Results of all checks of bodies on a machine.
#[derive(Debug)]
pub struct PlacementVerification {
    /// Walls, clearance, containment and keep-out boxes, in the build volume's frame.
    pub proof: LayoutProof,
    /// Filled area of each layer, if the machine has a cap on it and no body is outside the volume.
    pub layers: Option<LayerAreas>,
    /// How the bodies can be taken apart; `None` = locked parts are allowed, so this was not checked.
    pub disassembly: Option<Disassembly>,
    interlock: InterlockRule,
}

impl MachineSpec {
    /// Checks bodies in the build volume's frame.
    pub fn verify_placements(&self, bodies: &[PlacedSolid]) -> PlacementVerification {
        let room_mm = self.build_volume().size_mm;
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let prover = LayoutProver::new(bodies, threads);
        let proof = prover.prove_layout(room_mm, self.clearance_z_extra_mm, &self.keep_out_in_volume());
        // A body outside is reported anyway; it would give a layer list of unlimited length, so the layers are not
        // counted.
        let is_counted = self.layer_cap.cap_mm2().is_some() && proof.outside.is_empty();
        let placed = bodies.iter().map(|body| (&*body.mesh, body.pose));
        let layers = is_counted.then(|| LayerAreas::from_meshes(placed, self.layer_cap));
        let apart = Separability::disassemble_under(self.interlock, &prover);
        PlacementVerification { proof, layers, disassembly: apart, interlock: self.interlock }
    }
}

impl PlacementVerification {
    /// Whether all checks passed.
    pub fn is_proved(&self) -> bool {
        let is_locked = self.interlock == InterlockRule::Forbid && !self.locked_bodies().is_empty();
        self.proof.is_proved() && !is_locked && self.layer_fault().is_none()
    }

    /// Bodies that cannot be removed from the cake.
    pub fn locked_bodies(&self) -> &[usize] {
        self.disassembly.as_ref().map_or(&[], |apart| &apart.locked)
    }

    /// A description of the layer that is filled beyond the cap.
    pub fn layer_fault(&self) -> Option<String> {
        self.layers.as_ref().filter(|layers| !layers.keeps_cap()).map(LayerAreas::in_words)
    }

    /// The faults of the placements, one line each. `name` gives the name of a body.
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
