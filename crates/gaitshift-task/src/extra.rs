//! Reward terms and endings of one's own. *Not in the paper.*

use crate::expression::Quantities;
use crate::{EndReason, Expression, MOST_EXTRA, RewardTerms};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A reward term of one's own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExtraTerm {
    /// Its name: in logs and recordings it is `reward/NAME` and `reward_NAME`.
    pub name: String,
    /// Factor of the expression.
    pub weight: f64,
    /// Its value in every control period.
    pub expression: Expression,
}

/// A rule of one's own that ends episodes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExtraRule {
    /// Its name, which logs and recordings give as the reason of the end.
    pub name: String,
    /// The episode ends as a fall where this is not 0.
    pub expression: Expression,
}

/// Reward terms of one's own, at most [`MOST_EXTRA`], whose weights phases may replace.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<ExtraTerm>", into = "Vec<ExtraTerm>")]
pub struct ExtraTerms {
    terms: Arc<[ExtraTerm]>,
    /// The weights in force.
    weights: [f64; MOST_EXTRA],
}

/// Rules of one's own, at most [`MOST_EXTRA`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(try_from = "Vec<ExtraRule>", into = "Vec<ExtraRule>")]
pub struct ExtraRules(Arc<[ExtraRule]>);

impl Default for ExtraTerms {
    fn default() -> Self {
        Self {
            terms: Arc::default(),
            weights: [0.0; MOST_EXTRA],
        }
    }
}

impl From<ExtraTerms> for Vec<ExtraTerm> {
    fn from(extra: ExtraTerms) -> Self {
        let terms = extra.terms.iter().zip(extra.weights);
        terms
            .map(|(term, weight)| ExtraTerm {
                weight,
                ..term.clone()
            })
            .collect()
    }
}

impl From<ExtraRules> for Vec<ExtraRule> {
    fn from(extra: ExtraRules) -> Self {
        extra.0.to_vec()
    }
}

impl TryFrom<Vec<ExtraTerm>> for ExtraTerms {
    type Error = String;

    fn try_from(terms: Vec<ExtraTerm>) -> Result<Self, String> {
        check_names(
            "reward term",
            terms.iter().map(|term| term.name.as_str()),
            &RewardTerms::NAMES,
        )?;
        let mut weights = [0.0; MOST_EXTRA];
        for (weight, term) in weights.iter_mut().zip(&terms) {
            if !term.weight.is_finite() {
                return Err(format!(
                    "the weight of the reward term `{}` is {}, but it must be finite",
                    term.name, term.weight
                ));
            }
            *weight = term.weight;
        }
        let terms = terms.into();
        Ok(Self { terms, weights })
    }
}

impl TryFrom<Vec<ExtraRule>> for ExtraRules {
    type Error = String;

    fn try_from(rules: Vec<ExtraRule>) -> Result<Self, String> {
        let names = rules.iter().map(|rule| rule.name.as_str());
        check_names("rule", names, &EndReason::NAMES)?;
        Ok(Self(rules.into()))
    }
}

/// Names must do for columns of a file, and be of their own. The analysis has a wider rule of its own, for recordings of other
/// simulators (`is_extra`).
fn check_names<'a>(
    what: &str,
    names: impl Iterator<Item = &'a str>,
    taken: &[&str],
) -> Result<(), String> {
    let mut known: Vec<&str> = Vec::new();
    for name in names {
        let lower = |c: char| c.is_ascii_lowercase();
        let fits = name.starts_with(lower)
            && name.len() <= 40
            && name
                .chars()
                .all(|c| lower(c) || c.is_ascii_digit() || c == '_');
        if !fits {
            return Err(format!(
                "your {what} is named `{name}`, but a name begins with a lower-case letter and has up to 40 lower-case \
                 letters, digits and `_`"
            ));
        }
        if taken.contains(&name) {
            return Err(format!(
                "the {what} `{name}` has a reserved name; reserved are {}",
                taken.join(", ")
            ));
        }
        if known.contains(&name) {
            return Err(format!("two of the {what}s are named `{name}`"));
        }
        known.push(name);
    }
    if known.len() > MOST_EXTRA {
        return Err(format!(
            "you give {} {what}s, but {MOST_EXTRA} is the most; combine some in one expression",
            known.len()
        ));
    }
    Ok(())
}

impl ExtraTerms {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.terms.is_empty()
    }

    /// The terms, with the weights they were given.
    pub fn terms(&self) -> &[ExtraTerm] {
        &self.terms
    }

    /// Their names in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.terms.iter().map(|term| term.name.as_str())
    }

    /// The columns that recordings have for them, which are also their names in a step's `info`.
    pub fn columns(&self) -> impl Iterator<Item = String> {
        self.names().map(|name| format!("reward_{name}"))
    }

    /// The weight in force of the term of that name.
    pub fn weight_mut(&mut self, name: &str) -> Option<&mut f64> {
        let place = self.names().position(|known| known == name)?;
        self.weights.get_mut(place)
    }

    /// The weighted terms, the rest 0; nothing where one has no finite value.
    pub(crate) fn values(&self, quantities: &Quantities) -> Option<[f64; MOST_EXTRA]> {
        let mut values = [0.0; MOST_EXTRA];
        for ((value, term), weight) in values.iter_mut().zip(&*self.terms).zip(self.weights) {
            *value = weight * term.expression.evaluate(quantities).ok()?;
            if !value.is_finite() {
                return None;
            }
        }
        Some(values)
    }
}

impl ExtraRules {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The rules.
    pub fn rules(&self) -> &[ExtraRule] {
        &self.0
    }

    /// The first rule by which the episode is over, `Some(None)` if none is; nothing where one up to it has no finite value.
    pub(crate) fn ending(&self, quantities: &Quantities) -> Option<Option<EndReason>> {
        for (k, rule) in self.0.iter().enumerate() {
            if rule.expression.evaluate(quantities).ok()? != 0.0 {
                return Some(Some(EndReason::Rule(k as u8)));
            }
        }
        Some(None)
    }
}
