//! Serialization of an instance. Every distinct mesh is written once, and items refer to their mesh by its index. An
//! instance that is read passes the same checks as one that is constructed in code.

use std::{collections::HashMap, sync::Arc};

use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};
use solids::{Bounds, Mesh};

use crate::{BuildVolume, InstanceError, ItemPlacement, LayerAreaCap, NestingInstance, NestingItem, OrientationLimits};

/// The serialized form of an instance. `M` is a borrowed mesh for writing, and an owned mesh for reading.
#[derive(Serialize, Deserialize)]
#[serde(rename = "Instance", deny_unknown_fields)]
struct WrittenInstance<M> {
    volume: BuildVolume,
    clearance_mm: f64,
    #[serde(default)]
    clearance_z_extra_mm: f64,
    #[serde(default)]
    layer_cap: LayerAreaCap,
    #[serde(default)]
    keep_out: Vec<Bounds>,
    #[serde(default)]
    pinned: Vec<ItemPlacement>,
    items: Vec<WrittenItem>,
    meshes: Vec<M>,
}

/// The serialized form of an item. `mesh` is the index of its mesh.
#[derive(Serialize, Deserialize)]
#[serde(rename = "Item", deny_unknown_fields)]
struct WrittenItem {
    name: String,
    mesh: usize,
    copies: u32,
    #[serde(default)]
    orientation: OrientationLimits,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    clearance_mm: Option<f64>,
}

impl<'a> From<&'a NestingInstance> for WrittenInstance<&'a Mesh> {
    fn from(instance: &'a NestingInstance) -> Self {
        let mut meshes: Vec<&Mesh> = Vec::new();
        let mut known: HashMap<*const Mesh, usize> = HashMap::new();
        let item = |item: &'a NestingItem| WrittenItem {
            mesh: *known.entry(Arc::as_ptr(&item.mesh)).or_insert_with(|| {
                meshes.push(&item.mesh);
                meshes.len() - 1
            }),
            name: item.name.clone(),
            copies: item.copies,
            orientation: item.orientation.clone(),
            clearance_mm: item.clearance_mm,
        };
        Self {
            items: instance.items().iter().map(item).collect(),
            meshes,
            volume: instance.volume(),
            clearance_mm: instance.clearance_mm(),
            clearance_z_extra_mm: instance.clearance_z_extra_mm(),
            layer_cap: instance.layer_cap(),
            keep_out: instance.keep_out(),
            pinned: instance.pinned().to_vec(),
        }
    }
}

impl TryFrom<WrittenInstance<Mesh>> for NestingInstance {
    type Error = InstanceError;

    fn try_from(written: WrittenInstance<Mesh>) -> Result<Self, InstanceError> {
        let meshes: Vec<Arc<Mesh>> = written.meshes.into_iter().map(Arc::new).collect();
        let item = |(at, item): (usize, WrittenItem)| {
            let missing = InstanceError::NoMesh { item: at, mesh: item.mesh, meshes: meshes.len() };
            Ok(NestingItem {
                mesh: meshes.get(item.mesh).ok_or(missing)?.clone(),
                name: item.name,
                copies: item.copies,
                orientation: item.orientation,
                clearance_mm: item.clearance_mm,
            })
        };
        let items = written.items.into_iter().enumerate().map(item).collect::<Result<_, _>>()?;
        let instance = Self::new(written.volume, written.clearance_mm, items)?
            .with_clearance_z_extra(written.clearance_z_extra_mm)?
            .with_layer_cap(written.layer_cap)?
            .with_keep_out(&written.keep_out)?;
        Ok(instance.with_pinned(written.pinned))
    }
}

impl Serialize for NestingInstance {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        WrittenInstance::from(self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for NestingInstance {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        WrittenInstance::<Mesh>::deserialize(deserializer)?.try_into().map_err(D::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};
    use sample_parts::fixtures::star;
    use solids::Pose;

    use super::*;
    use crate::{
        NestingConfig, NestingSolution, OrientationRule, SearchBudget, TiltLimit, nest, tests::testing::block,
    };

    fn asked() -> NestingInstance {
        let knob = star(2, |d| 6.0 + (5.0 * d.x + 3.0 * d.y).sin());
        let tilted =
            OrientationLimits { rule: OrientationRule::Free, tilts: vec![TiltLimit::new(DVec3::ONE, 77.7).unwrap()] };
        let items = vec![
            NestingItem::new("knob", knob.clone(), 5),
            NestingItem::new("bar", block(DVec3::new(14.0, 1.0 / 0.3, 2.0)), 3)
                .with_orientation(OrientationRule::Upright),
            NestingItem::new("knob, tilted", knob, 2).with_orientation(tilted).with_clearance(2.5),
        ];
        let volume = BuildVolume { size_mm: DVec3::new(40.0, 40.0, 90.0) };
        let zone = Bounds { min: DVec3::new(-3.0, 0.0, 0.0), max: DVec3::new(5.0, 5.0, 20.0) };
        let pinned =
            ItemPlacement { item: 1, copy: 0, pose: Pose::new(DQuat::IDENTITY, DVec3::new(20.0, 20.0, 1.0 / 3.0)) };
        let cap = LayerAreaCap { layer_mm: 0.2, area_mm2: 900.0 };
        let instance = NestingInstance::new(volume, 1.1, items).unwrap().with_clearance_z_extra(0.4).unwrap();
        instance.with_layer_cap(cap).unwrap().with_keep_out(&[zone]).unwrap().with_pinned(vec![pinned])
    }

    fn nested(instance: &NestingInstance) -> NestingSolution {
        nest(instance, &NestingConfig::default(), &[], &SearchBudget::of_evaluations(1500), &mut ())
    }

    #[test]
    fn an_instance_comes_back_whole_and_nests_to_the_same_placements() {
        let instance = asked();
        let text = toml::to_string(&instance).unwrap();
        let back: NestingInstance = toml::from_str(&text).unwrap();
        assert_eq!(toml::to_string(&back).unwrap(), text);
        assert!(Arc::ptr_eq(&back.items()[0].mesh, &back.items()[2].mesh), "equal meshes stay one");
        let solution = nested(&instance);
        assert!(!solution.placements.is_empty());
        assert_eq!(nested(&back), solution);
    }

    #[test]
    fn a_solution_comes_back_to_the_last_digit() {
        let solution = nested(&asked());
        let text = toml::to_string(&solution).unwrap();
        assert_eq!(toml::from_str::<NestingSolution>(&text).unwrap(), solution);
        let placement = solution.placements[0];
        assert_eq!(toml::from_str::<ItemPlacement>(&toml::to_string(&placement).unwrap()).unwrap(), placement);
    }

    #[test]
    fn json_holds_an_endless_cap_and_names_what_is_wrong() {
        let item = NestingItem::new("cube", block(DVec3::splat(5.0)), 2);
        let instance = NestingInstance::new(BuildVolume { size_mm: DVec3::splat(20.0) }, 1.0, vec![item]).unwrap();
        let json = serde_json::to_value(&instance).unwrap();
        let back: NestingInstance = serde_json::from_value(json.clone()).unwrap();
        assert_eq!((back.layer_cap(), back.copy_count()), (LayerAreaCap::default(), 2));
        let refused = |change: &dyn Fn(&mut serde_json::Value)| {
            let mut wrong = json.clone();
            change(&mut wrong);
            serde_json::from_value::<NestingInstance>(wrong).unwrap_err().to_string()
        };
        assert!(
            refused(&|json| json["items"][0]["mesh"] = 3.into()).contains("item 0 names mesh 3, but there are only 1")
        );
        assert!(refused(&|json| json["clearance_mm"] = (-1).into()).contains("is not a distance"));
        assert!(refused(&|json| json["items"][0]["copies"] = 0.into()).contains("there is nothing to nest"));
        assert!(refused(&|json| json["margin"] = 1.into()).contains("unknown field `margin`"));
    }
}
