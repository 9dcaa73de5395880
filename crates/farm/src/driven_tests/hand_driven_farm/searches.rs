//! What a test looks at and does in the searches and other jobs of a hand-driven farm, and in its settings.

use std::sync::mpsc::{Sender, channel};

use jobs::BackgroundJob;
use settings::Settings;

use super::{HandDrivenFarm, MACHINE, MOST_TICKS, STEP};
use crate::{core::farm::Farm, open_build::batch};

/// A job in a folder that does not answer.
#[derive(Clone)]
struct StuckJob;

impl BackgroundJob<Farm> for StuckJob {
    const KIND: &'static str = "Stuck";
    type Outcome = ();
    type Desk<'f> = &'f mut Farm;

    fn subject(&self) -> String {
        String::new()
    }

    async fn on_done(self, _farm: Self::Desk<'_>, (): ()) -> anyhow::Result<()> {
        Ok(())
    }
}

impl HandDrivenFarm {
    /// Its settings, to change what no file of settings can say.
    pub fn settings_mut(&mut self) -> &mut Settings {
        &mut self.farm.as_mut().unwrap().settings
    }

    /// Looks whether the open build fires, as a tick does after its look at the clock.
    pub fn look_at_open_build(&mut self) {
        self.runtime.block_on(batch::update_open_build(&mut self.farm.as_mut().unwrap().desk(), MACHINE)).unwrap();
    }

    /// Lets time pass until a search for the open build has begun, and takes in nothing that it finds.
    pub fn begin_search(&mut self) {
        for _ in 0..MOST_TICKS {
            if self.farm.as_ref().unwrap().machines[MACHINE].open.search.is_some() {
                return;
            }
            self.hands.pass(STEP);
            self.begin_tick();
        }
        panic!("no search begins");
    }

    /// Starts a job that does not end before what is returned is dropped.
    pub fn begin_stuck_job(&mut self) -> Sender<()> {
        let (release, wait) = channel();
        self.farm.as_mut().unwrap().jobs.start(StuckJob, move || _ = wait.recv());
        release
    }

    /// Whether a search lowers the open build of a machine now.
    pub fn is_lowering(&self, machine: &str) -> bool {
        let night = &self.farm.as_ref().unwrap().machines[machine].open.night;
        night.search.as_ref().is_some_and(|search| !search.is_stopped())
    }

    /// Whether a final search runs, and is within its time.
    pub fn is_nesting(&self) -> bool {
        self.farm.as_ref().unwrap().nesting.searches.finals().any(|(_, search)| search.secs_over() == 0.0)
    }

    /// The farm asks the ledger again how far the search for an open build is.
    pub fn forget_night(&mut self, machine: &str) {
        self.farm.as_mut().unwrap().machines.get_mut(machine).unwrap().open.end_night();
    }

    /// The farm has no mesh in memory any more: what it needs is read again.
    pub fn forget_meshes(&self) {
        self.farm.as_ref().unwrap().meshes.mesh_cache.retain(|_| false);
    }

    /// The farm knows no layout of an open build any more, and searches its copies again.
    pub fn forget_layout(&mut self, machine: &str) {
        self.farm.as_mut().unwrap().machines.get_mut(machine).unwrap().open.reset();
    }
}
