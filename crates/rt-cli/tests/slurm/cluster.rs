//! A Slurm cluster of one machine, as a child of the test, with nothing of the system's own.

use std::fs;
use std::net::TcpListener;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

/// Programs of Debian's packages slurmctld, slurmd, slurm-client and munge.
const PROGRAMS: [&str; 6] = ["munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol"];

/// A cluster with eight processors, as it believes. It ends when it is dropped.
pub(crate) struct Cluster {
    folder: TempDir,
    daemons: Vec<Child>,
}

impl Cluster {
    /// Starts a cluster; returns the reason where that cannot be done.
    pub(crate) fn start() -> Result<Self, String> {
        if let Some(missing) = PROGRAMS.iter().find(|program| find(program).is_none()) {
            return Err(format!("there is no {missing}"));
        }
        let folder = tempfile::Builder::new().prefix("slurm").tempdir().expect("a folder");
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o755)).expect("set");
        let mut cluster = Self { folder, daemons: Vec::new() };
        for name in ["state", "spool"] {
            fs::create_dir(cluster.path(name)).expect("created");
        }
        fs::write(cluster.path("munge.key"), [42; 1024]).expect("written");
        fs::set_permissions(cluster.path("munge.key"), fs::Permissions::from_mode(0o600)).expect("set");
        fs::write(cluster.path("slurm.conf"), cluster.settings()).expect("written");
        let in_folder = |option: &str, name: &str| format!("--{option}={}", cluster.path(name).display());
        let munged = [
            "--foreground".to_owned(),
            "--force".to_owned(),
            in_folder("key-file", "munge.key"),
            in_folder("socket", "munge.sock"),
            in_folder("pid-file", "munged.pid"),
            in_folder("log-file", "munged.log"),
            in_folder("seed-file", "munge.seed"),
        ];
        cluster.daemon("munged", &munged)?;
        cluster.daemon("slurmctld", &["-D".to_owned(), "-c".to_owned()])?;
        cluster.daemon("slurmd", &["-D".to_owned(), "-N".to_owned(), "here".to_owned()])?;
        let is_up = cluster.wait(Duration::from_secs(30), || {
            let states = cluster.slurm("sinfo", &["--noheader", "--format=%t"]).map(|output| output.stdout);
            states.is_ok_and(|states| states.starts_with(b"idle"))
        });
        if is_up { Ok(cluster) } else { Err(format!("it did not start: {}", cluster.logs())) }
    }

    pub(crate) fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn slurm(&self, program: &str, arguments: &[&str]) -> std::io::Result<Output> {
        self.command(program).args(arguments).output()
    }

    /// A program that talks to the cluster, in its folder.
    pub(crate) fn command(&self, program: impl AsRef<std::ffi::OsStr>) -> Command {
        let mut command = Command::new(program);
        command.env("SLURM_CONF", self.path("slurm.conf")).current_dir(self.folder.path());
        command
    }

    /// Waits until the condition is true; returns false after the deadline.
    pub(crate) fn wait(&self, at_most: Duration, mut is_so: impl FnMut() -> bool) -> bool {
        let started = Instant::now();
        while started.elapsed() < at_most {
            if is_so() {
                return true;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        false
    }

    pub(crate) fn logs(&self) -> String {
        ["munged.log", "slurmctld.log", "slurmd.log"]
            .map(|name| fs::read_to_string(self.path(name)).unwrap_or_default())
            .join("\n")
    }

    fn daemon(&mut self, program: &str, arguments: &[String]) -> Result<(), String> {
        let path = find(program).ok_or_else(|| format!("there is no {program}"))?;
        let child = self.command(path).args(arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
        self.daemons.push(child.map_err(|error| format!("{program}: {error}"))?);
        Ok(())
    }

    fn settings(&self) -> String {
        let user = Command::new("id").arg("-un").output().expect("there is an id").stdout;
        let user = String::from_utf8(user).expect("text");
        let user = user.trim();
        let folder = self.folder.path().display();
        let [control, node] = free_ports();
        format!(
            "ClusterName=test\nSlurmctldHost=localhost(127.0.0.1)\nSlurmctldPort={control}\nSlurmdPort={node}\n\
             AuthType=auth/munge\nAuthInfo=socket={folder}/munge.sock\nCredType=cred/munge\nSlurmUser={user}\nSlurmdUser={user}\n\
             StateSaveLocation={folder}/state\nSlurmdSpoolDir={folder}/spool\n\
             SlurmctldPidFile={folder}/slurmctld.pid\nSlurmdPidFile={folder}/slurmd.pid\n\
             SlurmctldLogFile={folder}/slurmctld.log\nSlurmdLogFile={folder}/slurmd.log\n\
             ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nSwitchType=switch/none\nMpiDefault=none\n\
             SelectType=select/cons_tres\nSelectTypeParameters=CR_CPU\n\
             JobAcctGatherType=jobacct_gather/none\nAccountingStorageType=accounting_storage/none\n\
             ReturnToService=2\nSchedulerParameters=batch_sched_delay=0,sched_interval=1\nSlurmdParameters=config_overrides\n\
             NodeName=here NodeAddr=127.0.0.1 CPUs=8 State=UNKNOWN\n\
             PartitionName=all Nodes=here Default=YES MaxTime=INFINITE State=UP\n"
        )
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        // Jobs first, then the node, then who controls it.
        let _ = self.slurm("scancel", &["--state=RUNNING", "--full", "--signal=KILL"]);
        for daemon in self.daemons.iter_mut().rev() {
            let _ = Command::new("kill").args(["-s", "TERM", &daemon.id().to_string()]).status();
            let _ = daemon.wait();
        }
    }
}

/// Daemons lie where users have no path to.
fn find(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let mut folders: Vec<_> = std::env::split_paths(&path).collect();
    folders.extend(["/usr/sbin", "/sbin"].map(PathBuf::from));
    folders.into_iter().map(|folder| folder.join(program)).find(|file| file.is_file())
}

fn free_ports() -> [u16; 2] {
    let listeners = [(); 2].map(|()| TcpListener::bind("127.0.0.1:0").expect("a free port"));
    listeners.map(|listener| listener.local_addr().expect("bound").port())
}
