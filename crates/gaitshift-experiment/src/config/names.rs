//! Keys that are not known: what was probably meant, and what has become of those of earlier versions.

use super::{ConfigError, Experiment};

/// What a parser says, with the key that was probably meant.
pub(crate) fn parse_error(origin: &str, message: &str) -> ConfigError {
    ConfigError::Parse {
        origin: origin.to_owned(),
        message: did_you_mean(message.trim_end()),
    }
}

/// Names of earlier versions and what has become of them. A name that could stand elsewhere has one that stood beside it.
const GONE: [(&str, &str, &str); 29] = [
    (
        "schedule",
        "symmetry",
        "each phase has its own `learner` table now: `learner = { learning_rate = 5e-4, alpha = 0.1, horizon = 200 }`, and \
         `learner_end` with the values that they reach linearly",
    ),
    ("after_steps", "states", REHEARSAL_OF_PHASES),
    ("weight", "states", REHEARSAL_OF_PHASES),
    ("entropy_command_divisor", "", ENTROPY_OF_PHASES),
    ("entropy_share_at_zero", "", UNUSED),
    ("actor_average_decay", "", UNUSED),
    ("actor_layer_norm", "", UNUSED),
    ("max_grad_norm", "", UNUSED),
    ("average_evaluations", "", UNUSED),
    ("horizon_command_divisor", "", UNUSED),
    ("horizon_share_floor", "", UNUSED),
    ("alive_command_factor", "", UNUSED),
    ("energy_command_divisor", "", UNUSED),
    ("energy_reference_period_s", "", UNUSED),
    ("noise_correlation", "", UNUSED),
    ("actor_every", "", UNUSED),
    ("focus", "", UNUSED),
    ("focus_share", "", UNUSED),
    ("omega_e_floor", "", UNUSED),
    ("scale", "omega_e", UNUSED),
    (
        "speed_limit_m_per_s",
        "",
        "no recipe needs it any more; remove it, or say it with `[[task.reward.extra]]`: `expression = \"-2 * omega_v * max(x_velocity_m_per_s - 2.5, 0)\"`",
    ),
    ("start_speed_m_per_s", "", UNUSED),
    (
        "redraw_interval_s",
        "reward_end",
        "phases have no interval of their own; `curriculum.command.redraw_interval_s` is that of all",
    ),
    ("mirror_loss_weight", "", UNUSED),
    ("loss", "replay", UNUSED),
    ("network", "replay", UNUSED),
    (
        "mirrored_fraction",
        "",
        "`training.symmetry = \"replay\"` mirrors half of every batch",
    ),
    ("rehearsal_weight", "", REHEARSAL_OF_PHASES),
    (
        "rehearsal_rows",
        "",
        "`training.rehearsal.rows` says how many pairs an update rehearses",
    ),
];

const UNUSED: &str = "no recipe uses it, and it no longer exists; remove it";

const REHEARSAL_OF_PHASES: &str =
    "the weight is now set in the phases that rehearse: `learner = { rehearsal = 10 }`";

const ENTROPY_OF_PHASES: &str = "it no longer exists; for less noise at high commands give a phase a smaller α: `learner = { alpha = 0.05 }`";

/// The first keys of an experiment, by which the list of them is known.
const TABLES_OF_AN_EXPERIMENT: [&str; 4] = ["base", "name", "seed", "body"];

/// The name of `known` that was probably meant, if one is near: it differs by a slip, or has the name as a part, as
/// `theta_velocity_rad_per_s` has `theta_velocity`.
pub(crate) fn nearest<'a>(
    unknown: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    // To a name, or to what is left of it without some of its last words, which are units as a rule: `hip_stifness` is a slip
    // of `hip_stiffness_nm_per_rad`.
    let distance = |name: &str| {
        let whole = strsim::osa_distance(unknown, name);
        let shorter = name.match_indices('_').map(|(at, _)| &name[..at]);
        let shorter = shorter.filter(|part| part.len() > 4);
        shorter
            .map(|part| strsim::osa_distance(unknown, part) + 1)
            .fold(whole, usize::min)
    };
    let contained = |name: &str| {
        let unit = |rest: &str| rest.starts_with('_');
        name.strip_prefix(unknown).is_some_and(unit)
            || (unknown.len() > 2 && name.contains(unknown))
    };
    let likely = |name: &&str| distance(name) <= 1 + unknown.len() / 4 || contained(name);
    known
        .into_iter()
        .filter(likely)
        // Of equally near names the one that begins so: `z_m` for `z`, not `e`.
        .min_by_key(|name| (distance(name), !contained(name), !name.starts_with(unknown)))
}

/// `did you mean` with one name or two.
pub(crate) fn question(names: &[impl AsRef<str>]) -> String {
    let quoted: Vec<String> = names
        .iter()
        .map(|name| format!("`{}`", name.as_ref()))
        .collect();
    format!("did you mean {}?", quoted.join(" or "))
}

/// Keys of an experiment that are `unknown` but for the table they stand in, at most two; without one the nearest.
pub(super) fn elsewhere(unknown: &str) -> Vec<String> {
    let keys = Experiment::default().keys();
    let last = |key: &str| key.rsplit('.').next().unwrap_or(key).to_owned();
    let end = format!(".{unknown}");
    let mut same: Vec<String> = keys
        .iter()
        .filter(|key| key.ends_with(&end))
        .cloned()
        .collect();
    if same.is_empty() {
        let names: Vec<String> = keys.iter().map(|key| last(key)).collect();
        let near = nearest(unknown, names.iter().map(String::as_str));
        same.extend(
            keys.iter()
                .filter(|key| near == Some(last(key).as_str()))
                .cloned(),
        );
    }
    same.truncate(2);
    same
}

/// What a parser expects, in words of people who do not know Rust.
const PLAIN: [(&str, &str); 6] = [
    (
        "expected an array of length 2",
        "expected two numbers in brackets, such as [0, 1]",
    ),
    ("expected f64", "expected a number"),
    ("expected f32", "expected a number"),
    ("expected usize", "expected a whole number, 0 or greater"),
    ("expected u64", "expected a whole number, 0 or greater"),
    (
        "expected u32",
        "expected a whole number from 0 to 4294967295",
    ),
];

/// `expected struct Push` as `expected a table`.
fn without_type_name(message: String) -> String {
    const RUST: &str = "expected struct ";
    let Some((before, after)) = message.split_once(RUST) else {
        return message;
    };
    let rest = after.trim_start_matches(|c: char| c.is_alphanumeric() || c == '_');
    format!("{before}expected a table{rest}")
}

/// A parser's message of an unknown name, with what has become of it or the nearest known name instead of the list of
/// all, if it is a name of earlier versions or one is near.
pub fn did_you_mean(message: &str) -> String {
    let near = || {
        let start = message.rfind("unknown ")?;
        let (unknown, listed) = message[start..].split_once(", expected ")?;
        let unknown = unknown.split('`').nth(1)?;
        let gone = GONE.iter().find(|(name, beside, _)| {
            *name == unknown && (beside.is_empty() || listed.contains(&format!("`{beside}`")))
        });
        let what = &message[..start + message[start..].find(", expected ")?];
        let rest = listed.rfind('`').map_or("", |last| &listed[last + 1..]);
        if let Some((_, _, remedy)) = gone {
            return Some(format!("{what}: {remedy}{rest}"));
        }
        // Names stand between backticks; what follows the list, the line of a TOML file, does not.
        let known: Vec<&str> = listed.split('`').skip(1).step_by(2).collect();
        let mut names: Vec<String> = nearest(unknown, known.iter().copied())
            .map(str::to_owned)
            .into_iter()
            .collect();
        if known.starts_with(&TABLES_OF_AN_EXPERIMENT) {
            let elsewhere = elsewhere(unknown);
            if names.is_empty()
                || elsewhere
                    .iter()
                    .any(|key| key.ends_with(&format!(".{unknown}")))
            {
                names = elsewhere;
            }
        }
        (!names.is_empty()).then(|| format!("{what}; {}{rest}", question(&names)))
    };
    near().unwrap_or_else(|| {
        let plain = PLAIN
            .iter()
            .fold(message.to_owned(), |text, (rust, plain)| {
                text.replace(rust, plain)
            });
        let plain = without_type_name(plain);
        if plain.contains("floating point") {
            return plain.replace(
                "a whole number",
                "a whole number, without a point or an exponent",
            );
        }
        plain
    })
}
