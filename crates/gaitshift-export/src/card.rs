//! A controller's model card: what model hubs show beside a file, as Markdown with a YAML header.

use gaitshift_body::BodyParameters;
use gaitshift_experiment::{Controller, Judgement};
use std::fmt::Write;

/// A card that cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum CardError {
    /// The licence would break the header.
    #[error(
        "`{0}` is not a licence name; use letters, digits, `-`, `.` and `+`, for instance mit, apache-2.0 or cc-by-4.0"
    )]
    Licence(String),
}

/// The card of a controller: its gaits as `judgement` measured them, its use, its training, its body, its limits. `file` is
/// the name of the controller's file beside the card, `licence` the identifier that the hub shows.
///
/// # Errors
/// See [`CardError`].
pub fn card(
    controller: &Controller,
    judgement: &Judgement,
    file: &str,
    licence: Option<&str>,
) -> Result<String, CardError> {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-.+".contains(c);
    if let Some(licence) = licence.filter(|l| l.is_empty() || !l.chars().all(plain)) {
        return Err(CardError::Licence(licence.to_owned()));
    }
    let mut text = String::new();
    header(&mut text, licence);
    let period_ms = controller.task.control_period_s * 1e3;
    let shape = controller.policy.shape();
    let hidden: Vec<String> = shape.hidden.iter().map(usize::to_string).collect();
    let _ = write!(
        text,
        "# A biped with passive hips: one controller, one command\n\n\
         This controller drives the two linear actuators of gaitshift's planar biped, one along each leg; nothing drives the \
         hips. Its only command is `omega_v`, the weight of forward speed in the reward that it was trained with. It reads 14 \
         observations and gives 2 commands in [-1, 1] every {period_ms} ms (hidden layers: {}).\n\n",
        hidden.join(", ")
    );
    gaits(&mut text, judgement);
    use_it(&mut text, file);
    training(&mut text, controller);
    body(&mut text, &controller.body);
    text.push_str(
        "## Limits\n\n\
         It was trained and measured in simulation, in the plane, on the body above. It has not been tried on a real robot.\n",
    );
    Ok(text)
}

fn header(text: &mut String, licence: Option<&str>) {
    text.push_str("---\nlibrary_name: gaitshift\npipeline_tag: reinforcement-learning\n");
    if let Some(licence) = licence {
        let _ = writeln!(text, "license: {licence}");
    }
    text.push_str("tags:\n");
    for tag in [
        "reinforcement-learning",
        "soft-actor-critic",
        "robotics",
        "biped",
        "gait",
    ] {
        let _ = writeln!(text, "- {tag}");
    }
    text.push_str("---\n\n");
}

fn gaits(text: &mut String, judgement: &Judgement) {
    text.push_str(
        "## What it does\n\n\
         | omega_v | gait | upright, s | speed, m/s | Froude number v / √(g l) | double support | flight | cost of transport |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    let number = |value: Option<f64>, decimals: usize| {
        // Adding 0 turns -0 into 0.
        value.map_or_else(
            || "–".to_owned(),
            |value| format!("{:.decimals$}", value + 0.0),
        )
    };
    for row in &judgement.rows {
        let s = &row.summary;
        let _ = writeln!(
            text,
            "| {} | {} | {:.1} | {} | {} | {} | {} | {} |",
            row.omega_v,
            s.gait,
            s.survived_s,
            number(s.speed_m_per_s, 2),
            number(s.froude, 2),
            number(s.double_support, 2),
            number(s.flight, 2),
            number(s.cost_of_transport, 3),
        );
    }
    let _ = write!(
        text,
        "\nThe first seconds, in which a motion settles, are left out. {} of {} criteria are met",
        judgement.met(),
        judgement.checks.len()
    );
    let missed: Vec<&str> = judgement
        .checks
        .iter()
        .filter(|check| !check.met)
        .map(|check| check.name.as_str())
        .collect();
    if missed.is_empty() {
        text.push_str(".\n\n");
    } else {
        let _ = write!(text, ". Not met: {}.\n\n", missed.join("; "));
    }
}

fn use_it(text: &mut String, file: &str) {
    let _ = write!(
        text,
        "## Use\n\n\
         ```sh\n\
         gaitshift demo --controller {file}\n\
         gaitshift view --controller {file}\n\
         ```\n\n\
         ```python\n\
         import gaitshift\n\n\
         controller = gaitshift.Controller.load(\"{file}\")\n\
         recording = controller.record([(8.0, 0.0), (8.4, 3.0)], duration_s=16.0)  # omega_v from 0 to 3 in 0.4 s\n\
         print(recording.summary()[\"gait\"])\n\
         ```\n\n"
    );
}

fn training(text: &mut String, controller: &Controller) {
    let p = &controller.provenance;
    let _ = write!(
        text,
        "## Training\n\nSoft Actor-Critic, experiment `{}` (digest {}), seed {}, {} environment steps, {} updates, gaitshift {}",
        p.experiment,
        p.experiment_digest.as_deref().unwrap_or("unknown"),
        p.seed,
        p.environment_steps,
        p.updates,
        p.version
    );
    let _ = write!(text, ".\n\n```sh\n{}\n```\n\n", p.command);
    if !p.edits.is_empty() {
        text.push_str("The run's configuration was edited during training, so the command alone does not reproduce it:\n\n");
        for edit in &p.edits {
            let _ = writeln!(text, "- {edit}");
        }
        text.push('\n');
    }
}

fn body(text: &mut String, body: &BodyParameters) {
    let _ = write!(
        text,
        "## Body\n\n{} kg, legs of {} m. ",
        body.total_mass_kg(),
        body.leg_length_m
    );
    let (own, usual) = (values(body), values(&BodyParameters::default()));
    let changed: Vec<_> = own
        .iter()
        .filter(|(key, value)| usual.get(*key) != Some(value))
        .collect();
    if changed.is_empty() {
        text.push_str("gaitshift's default body: the paper's Table 1, and what the paper leaves open as in its documentation.\n\n");
    } else {
        text.push_str("It differs from gaitshift's default body in:\n\n| parameter | value | default |\n| --- | --- | --- |\n");
        for (key, value) in changed {
            let default = usual.get(key).map(ToString::to_string).unwrap_or_default();
            let _ = writeln!(text, "| `{key}` | {value} | {default} |");
        }
        text.push('\n');
    }
}

/// The body's parameters by name.
fn values(body: &BodyParameters) -> serde_json::Map<String, serde_json::Value> {
    match serde_json::to_value(body) {
        Ok(serde_json::Value::Object(map)) => map,
        _ => serde_json::Map::new(),
    }
}
