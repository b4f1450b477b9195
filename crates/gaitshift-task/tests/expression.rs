//! Contract: an expression has the usual precedences and functions, over quantities by the names and in the units of the
//! recording; what is wrong with one is said when it is read, in branches that are not entered too; it knows whether it
//! tells left from right.

use gaitshift_task::{Expression, QUANTITIES};

fn parse(text: &str) -> Result<Expression, String> {
    Expression::try_from(text.to_owned())
}

fn refused(text: &str, parts: &[&str]) {
    let error = parse(text).unwrap_err();
    for part in parts {
        assert!(error.contains(part), "`{text}`: {error}");
    }
}

#[test]
fn what_is_wrong_is_said_when_it_is_read() {
    refused("theta", &["unknown quantity `theta`", "`theta_rad`"]);
    refused("theta_rad +", &["unexpected end", "at its end"]);
    refused("abs(theta_rad", &["unclosed parenthesis", "character 4"]);
    refused(
        "theta_rad $ 2",
        &["unexpected character", "`$`", "character 11"],
    );
    refused("2 theta_rad", &["unexpected", "`theta_rad`"]);
    refused("größe", &["unexpected character"]);
    refused("", &["unexpected end"]);
    refused(
        "square(theta_rad)",
        &["unknown function `square`", "`sqrt`"],
    );
    refused("hypot(theta_rad)", &["`hypot`", "1 argument "]);
    refused("max(1, 2, 3, 4, 5, 6, 7, 8, 9)", &["too many arguments"]);
    // In C too it compares 1 or 0.
    refused("0.1 < z_m < 0.9", &["`a < b && b < c`"]);
    refused("max(1 <= z_m >= 0, 2)", &["`a < b && b < c`"]);
    for sound in [
        "0.1 < z_m && z_m < 0.9",
        "(z_m < 1) == (theta_rad > 0)",
        "z_m < 1 == theta_rad > 0",
        "z_m < 1 ? theta_rad < 0 : 1",
        "max(z_m < 1, theta_rad < 0)",
    ] {
        parse(sound).unwrap();
    }
    // Python's words.
    refused("theta_rad > 0.3 and z_m > 1", &["`and`", "write `&&`"]);
    refused("theta_rad > 0.3 or z_m > 1", &["write `||`"]);
    // Of one number it would be the logarithm to base 10.
    refused("log(z_m)", &["`log(x, 10)`", "`ln(x)`"]);
    let long = vec!["theta_rad"; 300].join(" + ");
    refused(&long, &["too long"]);
    // A branch that no value enters at the start is looked at as well.
    refused("time_s > 9 ? pitch : 0", &["`pitch`"]);
    refused("time_s > 9 && hypot(1) > 0", &["`hypot`"]);
    refused("1 || x_mm > 0", &["`x_mm`"]);
}

#[test]
fn left_and_right_are_told_apart() {
    let symmetric = |text: &str| parse(text).unwrap().is_symmetric();
    assert!(symmetric("-theta_rad^2"));
    assert!(symmetric("right_command * left_command"));
    assert!(symmetric(
        "-abs(right_phi_rad + left_phi_rad) - (right_h_m^2 + left_h_m^2)"
    ));
    assert!(symmetric(
        "max(right_normal_force_n, left_normal_force_n) / 1000"
    ));
    assert!(!symmetric("right_command"));
    assert!(!symmetric("right_phi_rad - left_phi_rad"));
    assert!(!symmetric("right_normal_force_n > left_normal_force_n"));
    assert!(!symmetric("right_normal_force_n > 3e4"));
    assert!(!symmetric("z_m < 1 && right_phi_rad > 0.1 ? theta_rad : 0"));
    assert!(symmetric(
        "exp(-(x_velocity_m_per_s - 1)^2) + right_d_m^2 + left_d_m^2 + z_m"
    ));
    for name in QUANTITIES {
        let sided = name.starts_with("right_") || name.starts_with("left_");
        assert_eq!(symmetric(name), !sided, "{name}");
    }
}

#[test]
fn it_is_written_as_it_was_read() {
    let text = "-(theta_rad)**2 + min(1, x_m) * 1e-3";
    let expression = parse(text).unwrap();
    assert_eq!(expression.text(), text);
    assert_eq!(
        serde_json::to_string(&expression).unwrap(),
        format!("{text:?}")
    );
    assert_eq!(parse(text).unwrap(), expression);
    assert_ne!(parse("theta_rad").unwrap(), expression);
}
