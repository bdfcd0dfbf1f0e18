//! The option `--shard`: the part of the iterations that this process renders.

use crate::render::sequence::Shard;

/// A scheduler of array jobs, with the environment variables that contain the index of a job and the number
/// of jobs.
struct Scheduler {
    name: &'static str,
    index: &'static str,
    count: &'static str,
    /// The variables of the first index and of the step between indices, if they can differ from 0 and 1.
    first: Option<&'static str>,
    step: Option<&'static str>,
}

const SCHEDULERS: [Scheduler; 3] = [
    Scheduler {
        name: "Slurm",
        index: "SLURM_ARRAY_TASK_ID",
        count: "SLURM_ARRAY_TASK_COUNT",
        first: Some("SLURM_ARRAY_TASK_MIN"),
        step: Some("SLURM_ARRAY_TASK_STEP"),
    },
    // Kubernetes does not tell a pod the number of jobs, so the manifest must set this variable.
    Scheduler { name: "Kubernetes", index: "JOB_COMPLETION_INDEX", count: "JOB_COMPLETIONS", first: None, step: None },
    Scheduler {
        name: "AWS Batch",
        index: "AWS_BATCH_JOB_ARRAY_INDEX",
        count: "AWS_BATCH_JOB_ARRAY_SIZE",
        first: None,
        step: None,
    },
];

/// Reads a shard: `I/N`, or `auto` for the environment of an array job.
///
/// # Errors
/// The text is not a shard; the message says what is expected.
pub fn parse(text: &str) -> Result<Shard, String> {
    if text == "auto" {
        return from_environment(|name| std::env::var(name).ok());
    }
    let (index, count) = text.split_once('/').ok_or("expected I/N, such as 0/4, or auto")?;
    let number = |text: &str| text.parse().map_err(|_| "expected whole numbers I/N, such as 0/4".to_owned());
    shard(number(index)?, number(count)?)
}

fn shard(index: u32, count: u32) -> Result<Shard, String> {
    if count > Shard::MAX_COUNT {
        return Err(format!("expected at most {} shards, not {count}", Shard::MAX_COUNT));
    }
    if index >= count {
        return Err(format!("expected an index from 0 that is below the count, not {index} of {count}"));
    }
    Ok(Shard { index, count })
}

/// Returns the shard of this job of an array job. `variable` reads an environment variable.
///
/// # Errors
/// The process is not in an array job, or the values of its variables are invalid.
fn from_environment(variable: impl Fn(&str) -> Option<String>) -> Result<Shard, String> {
    let Some(scheduler) = SCHEDULERS.iter().find(|scheduler| variable(scheduler.index).is_some()) else {
        let names: Vec<_> =
            SCHEDULERS.iter().map(|scheduler| format!("{} ({})", scheduler.index, scheduler.name)).collect();
        return Err(format!("auto: not in an array job: expected one of {}", names.join(", ")));
    };
    let number = |name: &str| -> Result<u32, String> {
        let text = variable(name).ok_or_else(|| {
            format!(
                "auto: {} is set ({}), and {name} is not: expected the number of jobs there",
                scheduler.index, scheduler.name
            )
        })?;
        text.parse().map_err(|_| format!("auto: {name} is {text:?}: expected a whole number"))
    };
    let or = |name: Option<&str>, default| match name {
        Some(name) if variable(name).is_some() => number(name),
        _ => Ok(default),
    };
    let (first, step) = (or(scheduler.first, 0)?, or(scheduler.step, 1)?.max(1));
    let (index, count) = (number(scheduler.index)?, number(scheduler.count)?);
    let above = index.checked_sub(first).filter(|above| above.is_multiple_of(step));
    let above = above.ok_or_else(|| {
        format!("auto, from {}: expected indices from {first} in steps of {step}, not {index}", scheduler.name)
    })?;
    shard(above / step, count).map_err(|error| format!("auto, from {}: {error}", scheduler.name))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn within(variables: &[(&str, &str)]) -> Result<Shard, String> {
        let find = |name: &str| variables.iter().find(|(key, _)| *key == name).map(|(_, value)| (*value).to_owned());
        from_environment(find)
    }

    #[test]
    fn written_shards_are_read() {
        assert_eq!(parse("2/7"), Ok(Shard { index: 2, count: 7 }));
        assert_eq!(parse("65535/65536"), Ok(Shard { index: 65_535, count: 65_536 }));
        for wrong in ["", "2", "7/7", "0/0", "-1/2", "1/2/3", "a/b", "1.5/2", "Auto", "0/65537"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn each_scheduler_is_understood() {
        let expected = Ok(Shard { index: 3, count: 8 });
        let slurm = [("SLURM_ARRAY_TASK_ID", "3"), ("SLURM_ARRAY_TASK_COUNT", "8")];
        assert_eq!(within(&slurm), expected);
        let stepped = [
            ("SLURM_ARRAY_TASK_ID", "16"),
            ("SLURM_ARRAY_TASK_COUNT", "8"),
            ("SLURM_ARRAY_TASK_MIN", "10"),
            ("SLURM_ARRAY_TASK_STEP", "2"),
        ];
        assert_eq!(within(&stepped), expected);
        assert_eq!(within(&[("JOB_COMPLETION_INDEX", "3"), ("JOB_COMPLETIONS", "8")]), expected);
        assert_eq!(within(&[("AWS_BATCH_JOB_ARRAY_INDEX", "3"), ("AWS_BATCH_JOB_ARRAY_SIZE", "8")]), expected);
    }

    #[test]
    fn what_is_missing_or_wrong_is_named() {
        let error = |variables: &[(&str, &str)]| within(variables).unwrap_err();
        assert!(error(&[]).contains("SLURM_ARRAY_TASK_ID"));
        assert!(error(&[("JOB_COMPLETION_INDEX", "3")]).contains("JOB_COMPLETIONS"));
        assert!(error(&[("SLURM_ARRAY_TASK_ID", "x"), ("SLURM_ARRAY_TASK_COUNT", "8")]).contains("whole number"));
        assert!(error(&[("SLURM_ARRAY_TASK_ID", "8"), ("SLURM_ARRAY_TASK_COUNT", "8")]).contains("below the count"));
        // A list of indices such as 1,2,5 has no step: two jobs would have the same part, or one none.
        for (index, first, step) in [("5", "1", "1"), ("3", "2", "2"), ("1", "2", "1")] {
            let job = [
                ("SLURM_ARRAY_TASK_ID", index),
                ("SLURM_ARRAY_TASK_COUNT", "3"),
                ("SLURM_ARRAY_TASK_MIN", first),
                ("SLURM_ARRAY_TASK_STEP", step),
            ];
            assert!(error(&job).contains("auto, from Slurm: expected"), "{index} from {first} by {step}");
        }
    }
}
