//! Makes each desk of the farm.

use super::{
    desks::{Batching, Building, Receiving, Searching, Serving, SettingUp, Shared, Showing, Storing, Watching},
    farm::Farm,
    state::CompletionState,
};

/// What every step may use, of a farm whose other parts are lent too.
macro_rules! shared {
    ($farm:ident) => {
        Shared {
            settings: &$farm.settings,
            ledger: &$farm.ledger,
            lifecycle: &$farm.lifecycle,
            schedule: &mut $farm.schedule,
            alerts: &mut $farm.alerts,
        }
    };
}

impl<'f> From<&'f mut Farm> for Shared<'f> {
    fn from(farm: &'f mut Farm) -> Self {
        shared!(farm)
    }
}

impl<'f> From<&'f mut Farm> for Serving<'f> {
    fn from(farm: &'f mut Farm) -> Self {
        Self { shared: shared!(farm), machines: &mut farm.machines, jobs: &mut farm.jobs }
    }
}

impl<'f> From<&'f mut Farm> for Watching<'f> {
    fn from(farm: &'f mut Farm) -> Self {
        let (machines, jobs) = (&mut farm.machines, &mut farm.jobs);
        Self { shared: shared!(farm), machines, jobs, watch: &mut farm.watch }
    }
}

impl<'f> From<&'f mut Farm> for Showing<'f> {
    fn from(farm: &'f mut Farm) -> Self {
        let (machines, jobs) = (&mut farm.machines, &mut farm.jobs);
        Self { shared: shared!(farm), machines, jobs, display: &mut farm.display }
    }
}

impl<'f> From<&'f mut Farm> for SettingUp<'f> {
    fn from(farm: &'f mut Farm) -> Self {
        let (machines, meshes) = (&mut farm.machines, &mut farm.meshes);
        Self { shared: shared!(farm), machines, meshes, search_slots: &mut farm.nesting.searches.slots }
    }
}

impl<'f> From<&'f mut Farm> for Storing<'f> {
    fn from(farm: &'f mut Farm) -> Self {
        let forgetting = &mut farm.completion.forgetting;
        Self { shared: shared!(farm), jobs: &mut farm.jobs, meshes: &mut farm.meshes, forgetting }
    }
}

impl<'f> From<&'f mut Farm> for Receiving<'f> {
    fn from(farm: &'f mut Farm) -> Self {
        Self {
            shared: shared!(farm),
            machines: &mut farm.machines,
            jobs: &mut farm.jobs,
            meshes: &mut farm.meshes,
            completion: &mut farm.completion,
            reading: &mut farm.reading,
        }
    }
}

impl<'f> From<&'f mut Farm> for Searching<'f> {
    fn from(farm: &'f mut Farm) -> Self {
        Self {
            shared: shared!(farm),
            machines: &mut farm.machines,
            jobs: &mut farm.jobs,
            meshes: &mut farm.meshes,
            searches: &mut farm.nesting.searches,
        }
    }
}

impl<'f> From<&'f mut Farm> for Building<'f> {
    fn from(farm: &'f mut Farm) -> Self {
        let CompletionState { forgetting, released, .. } = &mut farm.completion;
        Self {
            shared: shared!(farm),
            machines: &mut farm.machines,
            jobs: &mut farm.jobs,
            meshes: &mut farm.meshes,
            forgetting,
            released,
            nesting: &mut farm.nesting,
        }
    }
}

impl<'f> From<&'f mut Farm> for Batching<'f> {
    fn from(farm: &'f mut Farm) -> Self {
        Self {
            shared: shared!(farm),
            machines: &mut farm.machines,
            jobs: &mut farm.jobs,
            meshes: &mut farm.meshes,
            completion: &mut farm.completion,
            reading: &mut farm.reading,
            nesting: &mut farm.nesting,
        }
    }
}
