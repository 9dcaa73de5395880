//! A hot folder on a file system that is unmounted and comes back: it is "unavailable", never "all files deleted".

use std::{
    fs,
    path::Path,
    process::{Command, Stdio},
};

use ledger::PartState;

use crate::support::{QUICK, TestFarm, block, wait_until_or};

fn says(farm: &TestFarm, words: &str) {
    wait_until_or(&format!("the log says {words:?}"), 20.0, || farm.log(), || farm.log().contains(words));
}

pub fn a_share_that_is_unmounted_and_mounted_again_goes_on_where_it_was() {
    let farm = TestFarm::new(QUICK);
    let inbox = farm.folder("inbox");
    fs::create_dir_all(&inbox).unwrap();
    let image = farm.root().join("image");
    let share = MountedShare::new(&image, &inbox).expect("file systems may be mounted here");
    let mut farm = farm;
    farm.start();
    farm.drop_across("a.stl", &block(20.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    share.unmount();
    says(&farm, "The hot folder is unavailable");
    assert!(fs::read_dir(&inbox).unwrap().count() == 0, "something was written into the mount point");
    assert!(share.mount());
    says(&farm, "Resolved: test: The hot folder is unavailable");
    farm.drop_across("b.stl", &block(10.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    assert!(farm.parts(PartState::Refused).is_empty());
    farm.stop();
    drop(share);
}

/// Why no share can be mounted here.
pub fn missing() -> Option<String> {
    let folder = tempfile::tempdir().unwrap();
    let (image, at) = (folder.path().join("image"), folder.path().join("at"));
    fs::create_dir(&at).unwrap();
    MountedShare::new(&image, &at).is_none().then(|| "needs mkfs.ext4 and the right to mount file systems".to_owned())
}

/// A file system in a file, mounted through a loop device; unmounted when dropped.
struct MountedShare<'a> {
    image: &'a Path,
    at: &'a Path,
}

impl<'a> MountedShare<'a> {
    /// `None` where mounting is not allowed.
    fn new(image: &'a Path, at: &'a Path) -> Option<Self> {
        fs::File::create(image).unwrap().set_len(16 << 20).unwrap();
        let made = Command::new("mkfs.ext4").arg("-q").arg(image).stderr(Stdio::null()).status();
        let share = Self { image, at };
        (made.is_ok_and(|status| status.success()) && share.mount()).then_some(share)
    }

    fn mount(&self) -> bool {
        let mount =
            Command::new("mount").args(["-o", "loop"]).args([self.image, self.at]).stderr(Stdio::null()).status();
        mount.is_ok_and(|status| status.success())
    }

    /// Unmounts the file system even while it is in use, as an administrator can.
    fn unmount(&self) {
        let _ = Command::new("umount").arg("-l").arg(self.at).stderr(Stdio::null()).status();
    }
}

impl Drop for MountedShare<'_> {
    fn drop(&mut self) {
        self.unmount();
    }
}
