//! Contract: a learner's setting out of range is named.

use gaitshift_task::{Keyed, LearnerSettings};

const OWN: LearnerSettings = LearnerSettings {
    learning_rate: 3e-4,
    alpha: 0.2,
    horizon: 100.0,
    rehearsal: 0.0,
};

#[test]
fn values_out_of_range_are_named() {
    let values = OWN.values();
    for (name, value) in LearnerSettings::KEYS.iter().zip(values) {
        LearnerSettings::check(name, name, value).unwrap();
        let error = LearnerSettings::check("a.b", name, -1.0).unwrap_err();
        assert!(error.to_string().contains("`a.b` is -1.0"), "{error}");
        assert!(LearnerSettings::check(name, name, f64::NAN).is_err());
        assert!(LearnerSettings::check(name, name, f64::INFINITY).is_err());
    }
    assert!(LearnerSettings::check("r", "learning_rate", 0.0).is_err());
    assert!(LearnerSettings::check("h", "horizon", 0.5).is_err());
}
