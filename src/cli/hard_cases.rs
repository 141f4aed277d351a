//! `pellucid hard-cases`: every numerically hard case on the present adapter, against the `f64` oracle.

use clap::Args;
use serde::Serialize;

use super::failure::{Exit, Failure, printable};
use super::output::{self, Progress};
use crate::gpu::{AdapterFacts, Gpu, GpuOptions};
use crate::render::Renderer;
use crate::scene::hard_case::{Contrast, HardCase};
use crate::tradeoff::hard_cases::{self, Effort, Outcome, Verdict};

/// Options of `hard-cases`.
#[derive(Args, Clone, Debug)]
pub struct HardCasesArgs {
    /// Cases to run, or the beginning of their names, as in t01 [default: all]
    #[arg(value_name = "NAME")]
    pub names: Vec<String>,
    /// Print what the cases are and why each is hard, and run nothing
    #[arg(long)]
    pub list: bool,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// Print a table of Markdown
    #[arg(long, conflicts_with_all = ["json", "list"])]
    pub markdown: bool,
    /// Random scenes of each case that has such; 256 make a picture
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000), default_value_t = Effort::USUAL.random_scenes)]
    pub scenes: u32,
    /// As many random scenes as a release is checked with: 100000
    #[arg(long, conflicts_with = "scenes")]
    pub full: bool,
    /// Leave out the printed methods and planted errors
    #[arg(long)]
    pub ours_only: bool,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Report<'a> {
    adapter: &'a AdapterFacts,
    version: &'static str,
    cases: &'a [Outcome],
}

/// What `--list --json` prints.
#[derive(Serialize)]
struct Listed {
    name: &'static str,
    trap: &'static str,
    technique: &'static str,
    why: &'static str,
    measured: &'static str,
    unit: &'static str,
    bound: f64,
    contrast: Option<&'static str>,
}

type Chosen = Vec<(&'static str, &'static HardCase)>;

fn chosen(names: &[String]) -> Result<Chosen, Failure> {
    let names: Vec<String> = names.iter().map(|n| n.to_lowercase()).collect();
    let unknown =
        names.iter().find(|n| n.is_empty() || !hard_cases::all().any(|(_, case)| case.name.starts_with(n.as_str())));
    if let Some(name) = unknown {
        let known: Vec<&str> = hard_cases::all().map(|(_, case)| case.name).collect();
        let message = format!("no hard case is called '{name}'; there are {}", known.join(", "));
        return Err(Failure::new(Exit::Usage, message));
    }
    let asked_for = |case: &HardCase| names.is_empty() || names.iter().any(|n| case.name.starts_with(n.as_str()));
    Ok(hard_cases::all().filter(|(_, case)| asked_for(case)).collect())
}

fn list(cases: &Chosen, json: bool) -> Result<(), Failure> {
    let listed = cases.iter().map(|&(technique, case)| Listed {
        name: case.name,
        trap: case.trap,
        technique,
        why: case.why,
        measured: case.measure.what(),
        unit: case.measure.unit(),
        bound: case.bound,
        contrast: case.contrast.as_ref().map(|c| c.method().label),
    });
    let listed: Vec<Listed> = listed.collect();
    if json {
        return output::print(output::json(&listed)?.as_bytes());
    }
    let text: String = cases
        .iter()
        .map(|(technique, case)| {
            let bound = hard_cases::figure_text(case.bound, case.measure.unit());
            let contrast = case.contrast.as_ref().map_or_else(String::new, |c| {
                let kind = if matches!(c, Contrast::Printed(_)) { "printed" } else { "planted" };
                format!("; {kind}: {}", c.method().label)
            });
            let measured = case.measure.what();
            format!("{} ({technique})\n    {}\n    {measured}, at most {bound}{contrast}\n", case.name, case.why)
        })
        .collect();
    output::print(text.as_bytes())
}

/// Runs the cases and prints a table.
///
/// # Errors
/// [`Exit::Usage`] for a name that no case has, [`Exit::NoAdapter`] without an adapter, [`Exit::General`] if a case fails.
pub fn run(args: &HardCasesArgs) -> Result<(), Failure> {
    let cases = chosen(&args.names)?;
    if args.list {
        return list(&cases, args.json);
    }
    let progress = Progress::new();
    progress.stage("starting the adapter");
    let gpu = Gpu::new(&GpuOptions::default()).map_err(|e| Failure::of(Exit::NoAdapter, &e))?;
    let facts = gpu.facts().clone();
    let mut renderer = Renderer::new(gpu).map_err(|e| Failure::of(Exit::General, &e))?;
    let random_scenes = if args.full { Effort::MANY_SCENES } else { args.scenes };
    let effort = Effort { random_scenes, contrasts: !args.ours_only };
    let mut outcomes = Vec::with_capacity(cases.len());
    for (i, (technique, case)) in cases.iter().enumerate() {
        progress.stage(&format!("{} of {}: {}", i + 1, cases.len(), case.name));
        outcomes.push(hard_cases::run(&mut renderer, technique, case, effort));
    }
    drop(progress);
    let text = if args.json {
        output::json(&Report { adapter: &facts, version: env!("CARGO_PKG_VERSION"), cases: &outcomes })?
    } else if args.markdown {
        hard_cases::markdown(&outcomes)
    } else {
        let AdapterFacts { name, backend, driver, driver_info, .. } = &facts;
        let adapter = printable(&format!("{name} ({backend}, {driver} {driver_info})"));
        format!("{adapter}\n\n{}\n{}\n", hard_cases::text(&outcomes), summary(&outcomes))
    };
    output::print(text.as_bytes())?;
    judge(&outcomes)
}

fn count(outcomes: &[Outcome], verdict: Verdict) -> usize {
    outcomes.iter().filter(|o| o.verdict == verdict).count()
}

fn summary(outcomes: &[Outcome]) -> String {
    let [passed, failed, skipped] =
        [Verdict::Passed, Verdict::Failed, Verdict::Skipped].map(|verdict| count(outcomes, verdict));
    let ambiguous: usize = outcomes.iter().map(|o| o.ambiguous).sum();
    let samples: usize = outcomes.iter().map(|o| o.samples).sum();
    format!(
        "{passed} passed, {failed} failed, {skipped} skipped; of {} samples {} are ambiguous and count neither way; * an \
         error planted into ours, where the paper prints none",
        output::grouped(samples as u64),
        output::grouped(ambiguous as u64)
    )
}

fn judge(outcomes: &[Outcome]) -> Result<(), Failure> {
    match count(outcomes, Verdict::Failed) {
        0 => Ok(()),
        failed => {
            let names: Vec<&str> = outcomes.iter().filter(|o| o.verdict == Verdict::Failed).map(|o| o.name).collect();
            let message = format!("{failed} of {} hard cases failed: {}", outcomes.len(), names.join(", "));
            Err(Failure::new(Exit::General, message))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_failed_case_makes_the_exit_code() {
        let outcome = |verdict| Outcome {
            name: "t99-test",
            trap: "",
            technique: "passes/none",
            why: "",
            measured: "layers wrong",
            unit: " %",
            bound: 0.0,
            ours: Some(1.0),
            samples: 1234,
            ambiguous: 5,
            contrast: None,
            verdict,
            reason: None,
        };
        assert_eq!(judge(&[outcome(Verdict::Passed), outcome(Verdict::Skipped)]), Ok(()));
        let outcomes = [outcome(Verdict::Passed), outcome(Verdict::Failed)];
        let failure = judge(&outcomes).unwrap_err();
        assert_eq!((failure.exit, failure.message.as_str()), (Exit::General, "1 of 2 hard cases failed: t99-test"));
        assert!(summary(&outcomes).starts_with("1 passed, 1 failed, 0 skipped; of 2 468 samples 10 are ambiguous"));
    }

    #[test]
    fn names_are_beginnings_of_names() {
        let names = |list: &[&str]| -> Vec<&str> {
            let list: Vec<String> = list.iter().map(|n| (*n).to_owned()).collect();
            chosen(&list).unwrap().iter().map(|(_, case)| case.name).collect()
        };
        assert_eq!(names(&["t01"]), ["t01-equal-keys"]);
        assert!(names(&["t02", "t09-normals"]).len() > 3);
        assert_eq!(names(&[]).len(), hard_cases::all().count());
        assert_eq!(chosen(&["t99".to_owned()]).unwrap_err().exit, Exit::Usage);
    }
}
