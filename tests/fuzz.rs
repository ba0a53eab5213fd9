//! Fuzzing of scenes and rods: the committed corpus, and deterministic mutations of it.
//!
//! `LISSOM_FUZZ_RUNS=100000 cargo test --test fuzz` sets the number of mutations, `LISSOM_FUZZ_SEED` selects
//! other mutations, and `LISSOM_FUZZ_GROW=1` adds inputs with new outcomes to the corpus. An input that
//! causes a failure is written to `target/fuzz`; add it to `tests/fuzz/corpus` after the fix. `fuzz/` runs
//! the same targets under cargo-fuzz, which searches for new paths through the code.

#![allow(clippy::print_stderr, reason = "a fuzzer says what it tried and what it found")]

#[path = "fuzz/mutate.rs"]
mod mutate;
#[path = "fuzz/plan.rs"]
mod plan;
#[path = "fuzz/scene.rs"]
mod scene;
#[path = "fuzz/source.rs"]
mod source;

use std::collections::BTreeMap;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use mutate::Random;

/// Time limit for an input, in a build with debug assertions on a busy machine.
const TIME_LIMIT: Duration = Duration::from_secs(10);

/// A target: the function under test, and the mutations of its inputs.
struct Target {
    name: &'static str,
    run: fn(&[u8]) -> String,
    mutate: fn(&mut Random, &[u8], &[u8]) -> Vec<u8>,
    /// Default number of mutations.
    runs: usize,
}

const SCENE: Target =
    Target { name: "scene", run: scene::fuzz_scene, mutate: mutate::mutate_scene, runs: 1500 };

const PLAN: Target = Target { name: "plan", run: plan::fuzz_plan, mutate: mutate::mutate_bytes, runs: 500 };

impl Target {
    fn folder(&self) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus").join(self.name)
    }

    fn corpus(&self) -> Vec<Vec<u8>> {
        let mut paths: Vec<PathBuf> =
            fs::read_dir(self.folder()).unwrap().map(|entry| entry.unwrap().path()).collect();
        paths.sort();
        paths.iter().map(|path| fs::read(path).unwrap()).collect()
    }

    /// Saves an input that causes a failure; returns its path.
    fn keep(&self, input: &[u8]) -> PathBuf {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fuzz");
        fs::create_dir_all(&folder).unwrap();
        self.write(&folder, input)
    }

    fn write(&self, folder: &Path, input: &[u8]) -> PathBuf {
        let sum = input.iter().fold(0u64, |sum, &byte| Random(sum ^ u64::from(byte)).next());
        let path = folder.join(format!("{}-{sum:016x}", self.name));
        fs::write(&path, input).unwrap();
        path
    }

    /// Runs the target on the corpus and on mutations of it.
    fn test(&self) {
        if let Some(path) = std::env::var_os("LISSOM_FUZZ_INPUT") {
            if path.to_string_lossy().contains(self.name) {
                eprintln!("{}", (self.run)(&fs::read(path).unwrap()));
            }
            return;
        }
        let corpus = self.corpus();
        assert!(!corpus.is_empty(), "no corpus");
        let number = |name: &str| std::env::var(name).ok().map(|text| text.parse().expect(name));
        let runs: usize = number("LISSOM_FUZZ_RUNS").unwrap_or(self.runs);
        let seed = number("LISSOM_FUZZ_SEED").unwrap_or(0) as u64;
        let (started, inputs) = channel();
        let watch = thread::spawn({
            let target = Self { ..*self };
            move || target.watch(&inputs)
        });
        let mut outcomes = BTreeMap::new();
        let mut broken = Vec::new();
        let grows = std::env::var_os("LISSOM_FUZZ_GROW").is_some();
        let mut slowest = Duration::ZERO;
        let mut run = |input: Vec<u8>| {
            let clock = Instant::now();
            started.send(input.clone()).expect("the watch goes on");
            match catch_unwind(AssertUnwindSafe(|| (self.run)(&input))) {
                Ok(outcome) => {
                    let times = outcomes.entry(outcome).or_insert(0);
                    *times += 1;
                    if *times == 1 && grows {
                        self.write(&self.folder(), &input);
                    }
                }
                Err(_) => broken.push(self.keep(&input)),
            }
            slowest = slowest.max(clock.elapsed());
        };
        corpus.iter().for_each(|input| run(input.clone()));
        let mut random = Random(seed);
        for _ in 0..runs {
            let [input, other] = [0, 1].map(|_| &corpus[random.below(corpus.len())]);
            run((self.mutate)(&mut random, input, other));
        }
        drop(started);
        watch.join().unwrap();
        assert!(broken.is_empty(), "{} inputs break {}: {broken:?}", broken.len(), self.name);
        // If all inputs had the same outcome, nothing would be tested.
        assert!(outcomes.len() >= 10, "{outcomes:?}");
        if std::env::var_os("LISSOM_FUZZ_RUNS").is_some() {
            eprintln!("{}: {runs} runs, slowest {slowest:?}, {outcomes:#?}", self.name);
        }
    }

    /// Ends the process if an input takes too long, because nothing else ends a hang.
    fn watch(&self, inputs: &Receiver<Vec<u8>>) {
        let Ok(mut input) = inputs.recv() else { return };
        loop {
            match inputs.recv_timeout(TIME_LIMIT) {
                Ok(next) => input = next,
                Err(RecvTimeoutError::Disconnected) => return,
                Err(RecvTimeoutError::Timeout) => {
                    eprintln!("{}: hangs on {:?}", self.name, self.keep(&input));
                    std::process::abort();
                }
            }
        }
    }
}

#[test]
fn scenes() {
    SCENE.test();
}

#[test]
fn plans() {
    PLAN.test();
}
