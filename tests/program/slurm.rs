//! Jobs under Slurm: a controller and two nodes on this machine. A node is killed during the sweep of a job array, and
//! single runs are ended by Slurm, as at their time limit.
//!
//! Source: Slurm's own programs (`slurmctld`, `slurmd`, `sbatch`, `munged`) with a configuration of this test, as an
//! ordinary user. CI requires them; elsewhere, without them, the test is left out. A part of a sweep is identical on
//! every node, so that the gathered table has the bytes of a single process.

use std::fs;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::project;

/// The sweep: eight cases in four parts.
const SWEEP: [&str; 4] = ["--set", "V=560:910:50", "--quantity", "-1000*final(U2@REF)"];

/// A controller with two nodes, stopped at the end of the test.
struct SlurmCluster {
    folder: PathBuf,
    daemons: Vec<(&'static str, Child)>,
}

fn is_there(program: &str) -> bool {
    let paths = ["/usr/sbin", "/usr/local/sbin"].map(PathBuf::from);
    let own = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&own).chain(paths).any(|path| path.join(program).is_file())
}

fn installed() -> bool {
    // Slurm drops supplementary groups when it starts, which some containers do not allow.
    if fs::read_to_string("/proc/self/setgroups").is_ok_and(|word| word.trim() == "deny") {
        println!("left out: a sweep under Slurm (this container does not allow changing groups)");
        return false;
    }
    let found = ["slurmctld", "slurmd", "sbatch", "munged"].iter().all(|program| is_there(program));
    assert!(found || std::env::var_os("CI").is_none(), "in CI Slurm and munge must be installed");
    if !found {
        println!("left out: a sweep under Slurm (no slurmctld, slurmd, sbatch and munged)");
    }
    found
}

/// Returns a port that is free now. Another program may take it before a daemon does: `SlurmCluster::start` tries again.
fn port() -> u16 {
    TcpListener::bind("127.0.0.1:0").and_then(|own| own.local_addr()).expect("a port").port()
}

fn user() -> String {
    let output = Command::new("id").arg("-un").output().expect("id");
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

/// Returns the short host name, which identifies the nodes.
fn host() -> String {
    let output = Command::new("hostname").arg("-s").output().expect("hostname");
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

impl SlurmCluster {
    /// Starts a controller and two nodes with this number of processors, which may exceed those of the machine.
    fn start(folder: &Path, processors: usize) -> SlurmCluster {
        (1..=5)
            .find_map(|attempt| {
                let own = folder.join(format!("cluster-{attempt}"));
                fs::create_dir(&own).expect("a folder");
                SlurmCluster::start_once(&own, processors)
            })
            .expect("in five attempts a cluster all of whose daemons keep running")
    }

    /// Returns nothing if a daemon has ended before the nodes were idle, as it does where its port has been taken.
    fn start_once(folder: &Path, processors: usize) -> Option<SlurmCluster> {
        let mut cluster = SlurmCluster { folder: folder.to_owned(), daemons: Vec::new() };
        let at = folder.display();
        fs::create_dir(folder.join("state")).expect("a folder");
        fs::write(folder.join("munge.key"), [7_u8; 1024]).expect("a key");
        Command::new("chmod").args(["700"]).arg(folder).status().expect("chmod");
        Command::new("chmod").args(["600"]).arg(folder.join("munge.key")).status().expect("chmod");
        let munge = [
            "key-file=munge.key",
            "socket=munge.socket",
            "pid-file=munge.pid",
            "log-file=munge.log",
            "seed-file=munge.seed",
        ];
        let options = munge
            .map(|option| option.split_once('=').map_or(String::new(), |(name, file)| format!("--{name}={at}/{file}")));
        cluster.daemon(
            "munged",
            "munged",
            &options.iter().map(String::as_str).chain(["--foreground", "--force"]).collect::<Vec<_>>(),
        );
        cluster.wait_for("the socket of munge", || folder.join("munge.socket").exists());
        let (user, host) = (user(), host());
        let node = |name: &str| {
            format!(
                "NodeName={name} NodeHostname={host} NodeAddr=127.0.0.1 Port={} CPUs={processors} RealMemory=100 State=UNKNOWN\n",
                port()
            )
        };
        let text = format!(
            "ClusterName=test\nSlurmctldHost={host}(127.0.0.1)\nSlurmctldPort={}\nSlurmUser={user}\nSlurmdUser={user}\n\
             AuthType=auth/munge\nAuthInfo=socket={at}/munge.socket\nCredType=cred/munge\nStateSaveLocation={at}/state\n\
             SlurmdSpoolDir={at}/spool-%n\nSlurmctldPidFile={at}/controller.pid\nSlurmdPidFile={at}/node-%n.pid\n\
             SlurmctldLogFile={at}/controller.log\nSlurmdLogFile={at}/node-%n.log\nProctrackType=proctrack/pgid\nTaskPlugin=task/none\n\
             SchedulerType=sched/backfill\nSelectType=select/cons_tres\nSelectTypeParameters=CR_CPU\nReturnToService=2\n\
             MpiDefault=none\nSlurmdTimeout=10\nSlurmdParameters=config_overrides\n\
             {}{}PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n",
            port(),
            node("one"),
            node("two"),
        );
        fs::write(folder.join("slurm.conf"), text).expect("a configuration");
        cluster.daemon("controller", "slurmctld", &["-D", "-i"]);
        cluster.daemon("one", "slurmd", &["-D", "-N", "one"]);
        cluster.daemon("two", "slurmd", &["-D", "-N", "two"]);
        let begin = Instant::now();
        while cluster.command_output("sinfo", &["-h", "-t", "idle", "-o", "%D"]).trim() != "2" {
            assert!(begin.elapsed() < Duration::from_secs(120), "no two idle nodes in two minutes\n{}", cluster.logs());
            let ended = |daemon: &mut Child| daemon.try_wait().expect("a daemon").is_some();
            let name = cluster.daemons.iter_mut().find_map(|(name, daemon)| ended(daemon).then_some(*name));
            if let Some(name) = name {
                println!("{name} has ended\n{}", cluster.logs());
                return None;
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        Some(cluster)
    }

    fn daemon(&mut self, name: &'static str, program: &str, arguments: &[&str]) {
        let child = self.command(program).args(arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
        self.daemons.push((name, child.unwrap_or_else(|e| panic!("{program}: {e}"))));
    }

    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        let own = std::env::var("PATH").unwrap_or_default();
        let path = format!("{}/bin:{own}:/usr/sbin:/usr/local/sbin", self.folder.display());
        command.env("SLURM_CONF", self.folder.join("slurm.conf")).env("PATH", path).current_dir(project(""));
        command
    }

    fn command_output(&self, program: &str, arguments: &[&str]) -> String {
        // A controller that does not answer would be waited for.
        let limited = ["-k", "1", "60", program];
        let Output { stdout, .. } = self.command("timeout").args(limited).args(arguments).output().expect("it runs");
        String::from_utf8_lossy(&stdout).into_owned()
    }

    fn wait_for(&self, what: &str, is_so: impl Fn() -> bool) {
        let begin = Instant::now();
        while !is_so() {
            if begin.elapsed() > Duration::from_secs(120) {
                panic!("no {what} in two minutes\n{}", self.logs());
            }
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    fn logs(&self) -> String {
        let log = |name: &str| fs::read_to_string(self.folder.join(name)).unwrap_or_default();
        ["controller.log", "node-one.log", "node-two.log", "munge.log"].map(log).join("\n")
    }

    /// Submits a job and returns its number.
    fn submit(&self, job: &[&str], words: &[&str]) -> String {
        let log = format!("{}/job-%A_%a.log", self.folder.display());
        let number = self.command_output("sbatch", &[&["--parsable", "--no-requeue", "-o", &log], job, words].concat());
        assert!(number.trim().parse::<u32>().is_ok(), "sbatch: {number}");
        number.trim().to_owned()
    }

    /// Kills a node with all its processes.
    fn kill(&mut self, node: &str) {
        for (name, daemon) in &mut self.daemons {
            if *name == node {
                daemon.kill().and_then(|()| daemon.wait()).expect("a node");
            }
        }
        // Other tests have nodes of the same name.
        let configuration = self.folder.join("slurm.conf");
        let variables = [format!("SLURMD_NODENAME={node}"), format!("SLURM_CONF={}", configuration.display())];
        for process in fs::read_dir("/proc").expect("processes").flatten() {
            let read = |file: &str| fs::read_to_string(process.path().join(file)).unwrap_or_default();
            let environment = read("environ");
            let has = |wanted: &String| environment.split('\0').any(|variable| variable == wanted);
            if variables.iter().all(has) {
                // The job's supervising process is killed as well.
                let parent = read("status").lines().find_map(|l| l.strip_prefix("PPid:").map(|p| p.trim().to_owned()));
                let watches = |id: &str| {
                    fs::read_to_string(format!("/proc/{id}/comm")).is_ok_and(|comm| comm.starts_with("slurmstepd"))
                };
                let own = process.file_name().to_string_lossy().into_owned();
                let all: Vec<String> = parent.into_iter().filter(|id| watches(id)).chain([own]).collect();
                let _ = Command::new("kill").arg("-9").args(&all).stderr(Stdio::null()).status();
            }
        }
    }
}

impl Drop for SlurmCluster {
    fn drop(&mut self) {
        self.command_output("scancel", &["--state=RUNNING,PENDING", "-u", &user()]);
        std::thread::sleep(Duration::from_millis(300));
        for (_, daemon) in self.daemons.iter_mut().rev() {
            let _ = daemon.kill().and_then(|()| daemon.wait());
        }
    }
}

fn sweep(more: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_revolve");
    let all = [&["sweep", "input/ogive.inp"], &SWEEP[..], more].concat();
    Command::new(program).args(all).current_dir(project("")).output().expect("the program runs")
}

#[test]
fn sweep_survives_a_killed_node() {
    if !installed() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let (together, parts) = (folder.path().join("together"), folder.path().join("parts"));
    let mut cluster = SlurmCluster::start(folder.path(), 1);
    let name = |path: &Path| path.to_str().expect("a name").to_owned();
    let (together, out) = (name(&together), name(&parts));
    // The program, slowed down on the node that is to be killed so that it is killed during its work.
    let program = cluster.folder.join("bin/revolve");
    fs::create_dir(program.parent().expect("a folder")).expect("a folder");
    let waits = format!("[ \"$SLURMD_NODENAME\" != two ] || {{ touch '{out}.at_work'; sleep 600; }}");
    fs::write(&program, format!("#!/bin/sh\n{waits}\nexec '{}' \"$@\"\n", env!("CARGO_BIN_EXE_revolve")))
        .expect("a script");
    Command::new("chmod").arg("755").arg(&program).status().expect("chmod");
    cluster.submit(
        &["--array=1-4", "examples/slurm_array.sh", "input/ogive.inp"],
        &[&SWEEP[..], &["--out", &out]].concat(),
    );
    cluster.wait_for("task at work", || Path::new(&format!("{out}.at_work")).exists());
    cluster.kill("two");
    let written = || {
        fs::read_dir(&parts)
            .map_or(0, |all| all.flatten().filter(|e| e.path().extension().is_some_and(|e| e == "csv")).count())
    };
    cluster.wait_for("three parts", || written() == 3);
    let gathered = sweep(&["--out", &out, "--gather"]);
    let message_text = String::from_utf8_lossy(&gathered.stderr).into_owned();
    assert!(!gathered.status.success() && message_text.contains(" are missing"), "{message_text}");
    let missing = message_text.split("cases ").nth(1).and_then(|t| t.split(' ').next()).expect("which").to_owned();
    // The missing parts, as listed by the program, run on the remaining node.
    let words = SWEEP.map(|word| format!("'{word}'")).join(" ");
    let wrapped = format!("revolve sweep input/ogive.inp {words} --out '{out}' --cases {missing}");
    cluster.submit(&["-w", "one", "--wrap", &wrapped], &[]);
    cluster.wait_for("the fourth part", || written() == 4);
    let gathered = sweep(&["--out", &out, "--gather"]);
    assert!(gathered.status.success(), "{}", String::from_utf8_lossy(&gathered.stderr));
    assert!(sweep(&["--out", &together]).status.success());
    for file in ["ogive_sweep.csv", "ogive_sweep.svg", "ogive_sweep.png"] {
        let [a, b] = [&together, &out].map(|folder| fs::read(Path::new(folder).join(file)).expect(file));
        assert!(a == b, "{file} differs");
    }
}

/// `scancel` sends the signals that Slurm sends at the time limit of a job, which is at least a minute.
#[test]
fn ended_job_has_a_checkpoint_if_its_line_gives_time_for_it() {
    if !installed() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let cluster = SlurmCluster::start(folder.path(), 2);
    let run = format!("{} run input/taylor_copper.inp --set nr=100 --set nz=500", env!("CARGO_BIN_EXE_revolve"));
    let lines = [
        ("plain", run.clone()),
        ("exec", format!("exec {run}")),
        ("srun", format!("srun --mpi=none {run}")),
        ("every", format!("{run} --checkpoint-every 20")),
    ];
    let submit = |(name, line): &(&str, String)| {
        let (script, log, out) = (at(&format!("{name}.sh")), at(&format!("{name}.log")), at(name));
        fs::write(&script, format!("#!/bin/sh\n{line} --out '{}'\n", out.display())).expect("a script");
        let words = [&log, &script].map(|path| path.to_str().expect("a name").to_owned());
        cluster.submit(&["-o", &words[0], &words[1]], &[])
    };
    let jobs: Vec<String> = lines.iter().map(submit).collect();
    let has_checkpoint = |name: &str| at(name).join("taylor_copper.checkpoint").exists();
    let has_begun = |name: &str| fs::read_to_string(at(name).join("taylor_copper.sta")).is_ok_and(|t| !t.is_empty());
    cluster.wait_for("four runs", || lines.iter().all(|line| has_begun(line.0)));
    cluster.wait_for("a checkpoint", || has_checkpoint("every"));
    cluster.command_output("scancel", &jobs.iter().map(String::as_str).collect::<Vec<_>>());
    cluster.wait_for("end of all jobs", || cluster.command_output("squeue", &["-h"]).trim().is_empty());
    let checkpoints = lines.each_ref().map(|line| (line.0, has_checkpoint(line.0)));
    assert_eq!(checkpoints, [("plain", false), ("exec", true), ("srun", true), ("every", true)]);
    let log = |name: &str| fs::read_to_string(at(&format!("{name}.log"))).expect("a log");
    let noted = lines.each_ref().map(|line| (line.0, log(line.0).contains("note[K104]")));
    assert_eq!(noted, [("plain", true), ("exec", false), ("srun", false), ("every", false)]);
    assert!(log("exec").contains("continue with --resume"), "{}", log("exec"));
}
