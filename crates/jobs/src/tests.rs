//! What a job has comes back, and of a kind and subject one job runs.

use anyhow::Result;

use super::*;

#[derive(Clone)]
struct Add(u32);

impl BackgroundJob<Vec<String>> for Add {
    const KIND: &'static str = "Add";
    type Outcome = u32;
    type Desk<'a> = &'a mut Vec<String>;

    fn subject(&self) -> String {
        self.0.to_string()
    }

    async fn on_done(self, owner: Self::Desk<'_>, outcome: u32) -> Result<()> {
        owner.push(format!("{} gave {outcome}", self.0));
        Ok(())
    }

    async fn on_panic(self, owner: Self::Desk<'_>, message: &str) -> Result<()> {
        owner.push(format!("{} panicked: {message}", self.0));
        anyhow::bail!("it cannot be taken in")
    }
}

/// A text that a job has while it runs.
struct Text(String);

impl Carried<Vec<String>> for Text {
    type Desk<'a> = &'a mut Vec<String>;

    fn give_back(self, owner: Self::Desk<'_>) {
        owner.push(self.0);
    }
}

#[tokio::test]
async fn what_a_job_has_of_its_owner_is_back_before_its_end_is_taken_in_also_after_a_panic_or_twice() {
    let (mut jobs, mut owner) = (JobRunner::default(), Vec::new());
    let (go, wait) = std::sync::mpsc::channel::<()>();
    jobs.start_with(Add(1), Text("a".to_owned()), move |text| {
        text.0 += "b";
        wait.recv().unwrap();
        panic!("no sum")
    });
    jobs.start_with(Add(1), Text("of one that runs already".to_owned()), |_| 8);
    jobs.next_event().await.unwrap().apply_to(&mut owner).await.unwrap();
    go.send(()).unwrap();
    jobs.next_event().await.unwrap().apply_to(&mut owner).await.unwrap_err();
    assert_eq!(owner, ["of one that runs already", "ab", "1 panicked: no sum"]);
}

#[tokio::test]
async fn a_job_of_a_subject_runs_once_at_a_time_and_its_end_is_taken_in_even_after_a_panic() {
    let (mut jobs, mut owner) = (JobRunner::default(), Vec::new());
    let (go, wait) = std::sync::mpsc::channel::<()>();
    jobs.start(Add(1), move || wait.recv().map_or(0, |()| 7));
    jobs.start(Add(1), || 8);
    assert!(jobs.is_running::<Add>(1) && !jobs.is_running::<Add>(2) && jobs.running_subjects::<Add>().count() == 1);
    go.send(()).unwrap();
    jobs.start(Add(2), || panic!("no sum"));
    for _ in 0..2 {
        let event = jobs.next_event().await.unwrap();
        assert!(event.is_end_of::<Add>());
        let _ = event.apply_to(&mut owner).await;
    }
    owner.sort();
    assert_eq!(owner, ["1 gave 7", "2 panicked: no sum"]);
    assert!(jobs.is_idle() && jobs.try_next_event().is_none());
}
