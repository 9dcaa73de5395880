//! The exact test of a working layout: are all pairs clear on the triangles?

use super::{super::exact_contacts, CenterPose, MAX_MARGIN_MM, WorkingLayout};
use crate::prepare::prepared_instance::{PlacedItem, raised_bounds};

impl WorkingLayout<'_> {
    /// Returns the pieces if each of them is exactly inside and clear of all others. Otherwise increases the margins
    /// where it is not.
    pub(crate) fn confirm_clear(&mut self) -> Option<Vec<PlacedItem>> {
        let prepared = self.prepared;
        let pieces: Vec<PlacedItem> = (0..self.part_count()).map(|part| self.place_part(part)).collect();
        let mut inside = true;
        for (part, piece) in pieces[..self.parts.copy_count].iter().enumerate() {
            if !prepared.is_inside(piece, self.height_limit_mm + 1e-9) {
                inside = false;
                if !self.parts.fixed[part] {
                    self.walls[part].require_inside();
                }
            }
        }
        let clear = self.check_all_pairs(&pieces);
        (inside && clear).then(|| pieces[..self.parts.copy_count].to_vec())
    }

    /// A part where it stands; the exact bounds of one that has not moved since are known.
    fn place_part(&mut self, part: usize) -> PlacedItem {
        let now = self.move_counts[part];
        if let Some((_, piece)) = self.placed[part].as_ref().filter(|(then, _)| *then == now) {
            return piece.clone();
        }
        let CenterPose { rotation, center } = self.poses[part];
        let piece = self.prepared.place_item(self.parts.copies[part], rotation, center);
        self.placed[part] = Some((now, piece.clone()));
        piece
    }

    /// Whether all pairs are clear on the triangles. Those whose proxies overlap are tested first: they are few, and
    /// mostly not clear. Then the others need no test.
    fn check_all_pairs(&mut self, pieces: &[PlacedItem]) -> bool {
        let (overlapping, others): (Vec<_>, Vec<_>) =
            self.nearby_pairs().into_iter().partition(|&(one, other)| self.pair_energy(one, other) > 0.0);
        self.check_pairs(pieces, &overlapping) && self.check_pairs(pieces, &others)
    }

    /// Whether these pairs are clear on the triangles. For a pair that is not, stores its contacts or increases its
    /// margin.
    fn check_pairs(&mut self, pieces: &[PlacedItem], pairs: &[(usize, usize)]) -> bool {
        let prepared = self.prepared;
        let mut clear = true;
        for &(one, other) in pairs {
            let wanted = prepared.wanted_distance_mm(&pieces[one], &pieces[other]);
            let near = raised_bounds(&pieces[one].bounds, prepared.z_extra_mm);
            if near.distance(&raised_bounds(&pieces[other].bounds, prepared.z_extra_mm)) >= wanted {
                continue;
            }
            let now = (self.move_counts[one], self.move_counts[other]);
            if self.pair_records.get_pair(one, other).is_some_and(|record| record.clear_at == Some(now)) {
                continue;
            }
            self.evaluations += 1;
            let is_clear = prepared.is_clear(&pieces[one], &pieces[other]);
            let proxies_only = !self.interlock_memory.keeps_apart(one, other);
            let deceived = is_clear && proxies_only && self.pair_energy(one, other) > 0.0;
            let record = self.pair_records.pair_or_insert(one, other);
            record.known_overlap = None;
            if is_clear {
                record.clear_at = Some(now);
                // The proxies report an overlap that does not exist.
                record.margin = if deceived { (record.margin - 0.1).max(-MAX_MARGIN_MM) } else { record.margin };
                continue;
            }
            clear = false;
            if !exact_contacts::find_contacts(prepared, &pieces[one], &pieces[other], &mut record.contacts) {
                record.margin = (record.margin + 0.4).min(MAX_MARGIN_MM);
            }
        }
        clear
    }
}
