//! The demo's farm: a folder with a fast configuration, and sample parts that are dropped into its hot folder. Existing
//! files are never deleted or overwritten, so that the demo can run again and a person can continue with the farm by
//! hand.

use std::{
    fs::{self, File},
    io::{BufWriter, Write},
    net::{Ipv4Addr, SocketAddr, TcpListener},
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};
use build_file::write_stl;
use settings::load_settings;
use solids::{Mesh, Pose};

use crate::cli::UsageError;

/// The machine of the demo.
pub(super) const MACHINE: &str = "paper-200";
/// Marks a folder as a demo's farm.
const MARKER: &str = ".nestd-demo";
/// Sub-folder of the hot folder: the parts in it are one order.
const ORDER: &str = "order-1042";

/// Sample parts with the file names under which they are dropped: the name holds the copies, a folder is an order.
const SAMPLE_FILES: [(&str, &str); 21] = [
    ("axial_fan", "axial_fan_x4.stl"),
    ("bracket", "bracket_x6.stl"),
    ("ribbed_bracket", "ribbed_bracket_x3.stl"),
    ("duct", "duct_x2.stl"),
    ("ring", "ring_x6.stl"),
    ("spur_gear", "spur_gear_x4.stl"),
    ("lattice_block", "lattice_block_x3.stl"),
    ("clip", "clip_x10.stl"),
    ("knob", TICKETED_FILE),
    ("pulley", "pulley_x3.stl"),
    ("pawn", "pawn_x8.stl"),
    ("spring", "spring_x3.stl"),
    ("rail", "rail_x2.stl"),
    ("tray", "tray.stl"),
    ("lampshade", "lampshade.stl"),
    ("pipe_tee", "pipe_tee_x2.stl"),
    ("connecting_rod", "connecting_rod_x3.stl"),
    ("gyroid_ball", "gyroid_ball.stl"),
    ("hinge", "order-1042/hinge_x4.stl"),
    ("hook", "order-1042/hook_x3.stl"),
    ("honeycomb", "order-1042/honeycomb_x2.stl"),
];
/// The part that comes with a ticket beside it.
const TICKETED_FILE: &str = "knob.stl";
const TICKET: &str = "# A ticket: what the file name cannot say.\ncopies = 3\npriority = 80\norientation = \"upright\"\n\
                      note = \"handles for the test bench\"\n";
/// A ring with a hole in its surface, to show a refusal.
pub(super) const TORN_FILE: &str = "torn_ring.stl";

/// The demo's farm on disk.
#[derive(Debug)]
pub(super) struct DemoFarm {
    /// Its folder, absolute.
    pub root: PathBuf,
}

/// What was dropped into the hot folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct DroppedFiles {
    /// All part files, including the torn one.
    pub files: usize,
    /// How many of them must be refused.
    pub torn: usize,
}

impl DemoFarm {
    /// Opens the farm in `dir`, or creates it in an empty or new folder.
    ///
    /// # Errors
    /// [`UsageError`] when the folder holds files that are not the demo's.
    pub(super) fn open_or_make(dir: &Path) -> Result<Self> {
        let farm = Self { root: std::path::absolute(dir)? };
        let root = farm.root.display();
        let marker = farm.root.join(MARKER);
        fs::create_dir_all(&farm.root).with_context(|| format!("cannot make {root}"))?;
        let is_empty = fs::read_dir(&farm.root).with_context(|| format!("cannot look into {root}"))?.next().is_none();
        if !is_empty && !marker.exists() {
            let text = format!("{root} holds files that are not the demo's; name an empty folder with --dir");
            return Err(UsageError(text).into());
        }
        let Some(utf8) = farm.root.to_str() else {
            return Err(UsageError(format!("{root} is not UTF-8, which a configuration must be")).into());
        };
        write_new(
            &marker,
            "This folder is the farm of `nestd demo`. Delete it as a whole when you have seen enough.\n",
        )?;
        write_new(&farm.config_file(), &farm_toml(utf8, free_address()?))?;
        write_new(&farm.root.join("config/profiles").join(format!("{MACHINE}.toml")), MACHINE_TOML)?;
        Ok(farm)
    }

    /// The configuration file.
    pub(super) fn config_file(&self) -> PathBuf {
        self.root.join("config/nestd.toml")
    }

    /// The address of its pages, if its configuration has any.
    pub(super) fn page(&self) -> Option<String> {
        let settings = load_settings(Some(&self.config_file()), None).ok()?;
        settings.interfaces.web.map(|web| web.listen.to_string())
    }

    /// The daemon's log.
    pub(super) fn log_file(&self) -> PathBuf {
        self.root.join("daemon.log")
    }

    /// The ledger.
    pub(super) fn ledger_file(&self) -> PathBuf {
        self.root.join("state/nestd.db")
    }

    /// One of the machine's folders: inbox, queue, error, archive.
    pub(super) fn machine_folder(&self, kind: &str) -> PathBuf {
        self.root.join(kind).join(MACHINE)
    }

    /// Drops all sample parts, the ticket and the torn part.
    pub(super) fn drop_parts(&self) -> Result<DroppedFiles> {
        let inbox = self.machine_folder("inbox");
        fs::create_dir_all(inbox.join(ORDER)).with_context(|| format!("cannot make {}", inbox.display()))?;
        drop_file(&inbox.join(format!("{TICKETED_FILE}.toml")), |out| Ok(out.write_all(TICKET.as_bytes())?))?;
        let parts = sample_parts::all_samples();
        let named = |name: &str| parts.iter().find(|s| s.name == name).map(|s| &s.mesh).expect("the sample exists");
        for (name, file) in SAMPLE_FILES {
            drop_file(&inbox.join(file), |out| Ok(write_stl([(named(name), &Pose::IDENTITY)].into_iter(), out)?))?;
        }
        let torn = torn_mesh(named("ring"))?;
        drop_file(&inbox.join(TORN_FILE), |out| Ok(write_stl([(&torn, &Pose::IDENTITY)].into_iter(), out)?))?;
        Ok(DroppedFiles { files: SAMPLE_FILES.len() + 1, torn: 1 })
    }
}

/// The mesh without the last tenth of its triangles.
fn torn_mesh(mesh: &Mesh) -> Result<Mesh> {
    let kept = mesh.triangles().len() * 9 / 10;
    Ok(Mesh::new(mesh.vertices().to_vec(), mesh.triangles()[..kept].to_vec())?)
}

/// Writes a file unless it exists, and creates its folder.
fn write_new(file: &Path, text: &str) -> Result<()> {
    if let Some(folder) = file.parent() {
        fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    }
    if file.exists() {
        return Ok(());
    }
    fs::write(file, text).with_context(|| format!("cannot write {}", file.display()))
}

/// Writes a file under a hidden name and renames it, as a careful sender does. An existing file is kept.
fn drop_file(file: &Path, fill: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
    if file.exists() {
        return Ok(());
    }
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let part = file.with_file_name(format!(".{name}.part"));
    let write = || -> Result<()> {
        let mut out = BufWriter::new(File::create(&part)?);
        fill(&mut out)?;
        out.into_inner()?.sync_all()?;
        fs::rename(&part, file)?;
        Ok(())
    };
    write().with_context(|| format!("cannot drop {}", file.display()))
}

/// An address of this machine alone that nothing listens on.
fn free_address() -> Result<SocketAddr> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).context("no address is free for the pages")?;
    Ok(listener.local_addr()?)
}

fn farm_toml(root: &str, pages: SocketAddr) -> String {
    let root = toml::Value::String(root.to_owned());
    format!(
        "# The farm of `nestd demo`: as a real one, but in a hurry.\n\
         # Every option with its default and its meaning: config/nestd.toml in nestd's repository.\n\
         root = {root}\n\
         scan_secs = 1\n\n\
         # Its pages, for this machine alone.\n\
         [web]\n\
         listen = \"{pages}\"\n"
    )
}

/// The machine's file, with short times so that a newcomer does not wait.
const MACHINE_TOML: &str = "\
# The machine of the source paper.
volume_mm = [200, 200, 200]
clearance_mm = 3

# In a hurry: a real farm settles for 5 s and searches for a minute or more.
settle_secs = 1
arrival_secs = 2
final_secs = 8

# The demo may run again with the same parts.
duplicates = \"accept\"
";
