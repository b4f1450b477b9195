//! Contract: every figure stands beside the page as SVG, PNG, CSV and JSON, and on it; a run brings the returns of its episodes;
//! figures mark falls, fit a journal's columns and are one series for each experiment; captions say what was measured.

use crate::common::studies::study;
use crate::common::{run, text, written, written_with};
use gaitshift_report::{RecordedExperiment, Subject};
use std::collections::BTreeMap;

#[test]
fn every_figure_stands_beside_the_page_with_its_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let all = written(&mut [Subject::read(&run(folder.path())).unwrap()]);
    let mut figures: Vec<&str> = all
        .keys()
        .filter_map(|name| name.strip_suffix(".svg"))
        .collect();
    figures.sort_unstable();
    // The order of the folder, not of the page.
    let expected = [
        "bifurcation",
        "cost-of-transport",
        "energy-flow",
        "fig3-run-to-walk",
        "fig3-walk-to-run",
        "fig4-returns",
        "ground-reaction",
        "ground-steps",
        "hip-phase",
        "leg-force-length",
        "poses-run",
        "poses-walk",
        "steps-by-speed",
        "stride-energies",
        "sweep",
        "through-the-change",
        "walk-run-walk",
    ]
    .map(|name| format!("figures/{name}"));
    assert_eq!(figures, expected);
    let page = text(&all["report.html"]);
    assert_eq!(page.matches("<figure").count(), expected.len());
    for figure in figures {
        assert!(all.contains_key(&format!("{figure}.png")), "{figure}");
        let table: serde_json::Value =
            serde_json::from_slice(&all[&format!("{figure}.json")]).unwrap();
        let (columns, rows) = (&table["columns"], table["rows"].as_array().unwrap());
        let lines = text(&all[&format!("{figure}.csv")]).lines().count();
        assert!(!rows.is_empty() && lines == 1 + rows.len(), "{figure}");
        let width = columns.as_array().unwrap().len();
        assert!(
            rows.iter()
                .all(|row| row.as_array().unwrap().len() == width)
        );
    }
    // The return of the last episode, which ended in a fall.
    let returns = text(&all["figures/fig4-returns.csv"]);
    assert_eq!(returns.lines().last(), Some("10000.0,0.5,10.5,true"));
    // All fit two columns of a journal, 180 mm; those that are not wide fit one, 90 mm.
    for figure in figures_of(&all) {
        let svg = text(&all[&format!("{figure}.svg")]);
        let width: f64 = attribute(svg.lines().next().unwrap(), "width")
            .parse()
            .unwrap();
        assert!(width <= 680.0, "{figure}: {width}");
        if ["fig4-returns", "cost-of-transport"]
            .iter()
            .any(|name| figure.ends_with(name))
        {
            assert_eq!(width, 330.0, "{figure}");
        }
    }
    let bifurcation = page.find("It runs ").map(|at| &page[at..][..400]);
    assert!(
        page.contains("Rising, it fell nowhere; coming down, nowhere. At")
            && page.contains("It runs nowhere as the command rises"),
        "{bifurcation:?}"
    );
    assert!(page.contains("Of 6 random starts 0 fell."));
    // What is given and what is taken of the energy are the same, but for what the body holds more or less in the end.
    for omega_v in ["0.0", "3.0"] {
        let sum = |kind: &str| -> f64 {
            let rows = text(&all["figures/energy-flow.csv"]).lines();
            let rows = rows.map(|line| line.split(',').collect::<Vec<_>>());
            rows.filter(|cells| cells[0] == omega_v && cells[1] == kind)
                .flat_map(|cells| [3, 4].map(|k| cells[k].parse::<f64>().unwrap()))
                .sum()
        };
        let (given, taken) = (sum("given"), sum("taken"));
        assert!(
            (given - taken).abs() < 0.02 * given,
            "{given} J and {taken} J"
        );
    }
    // Of the episodes from step 8000 on one in three ended in a fall: more than twice the tenth that "almost none" allows.
    let claims = text(&all["claims.csv"]);
    let line = claims
        .lines()
        .find(|line| line.contains("with phase I"))
        .unwrap();
    assert!(line.contains("0.3333") && line.contains("fails"), "{line}");
}

fn figures_of(all: &BTreeMap<String, Vec<u8>>) -> Vec<&str> {
    all.keys()
        .filter_map(|name| name.strip_suffix(".svg"))
        .collect()
}

fn attribute<'a>(line: &'a str, name: &str) -> &'a str {
    let named = format!(" {name}=\"");
    line.split(&named)
        .nth(1)
        .unwrap()
        .split('"')
        .next()
        .unwrap()
}

// Thirty-four runs were thirty-four series in six looks.
#[test]
fn seeds_of_an_experiment_are_one_series_and_phase_one_is_set_beside_its_lack() {
    let folder = tempfile::tempdir().unwrap();
    let run = run(folder.path());
    let mut subjects = ["paper", "paper", "paper, without phase I"]
        .into_iter()
        .zip(1..)
        .map(|(group, seed)| Subject {
            name: format!("{group}, seed {seed}"),
            group: group.to_owned(),
            seed,
            run: Some(run.clone()),
            ..Subject::shipped().unwrap()
        })
        .collect::<Vec<_>>();
    // An experiment that was run earlier, of which little is known.
    let earlier = RecordedExperiment {
        name: "earlier".to_owned(),
        repeats: None,
        learner: None,
        runs: String::new(),
        seeds: vec![1, 2],
        claims: BTreeMap::new(),
        studies: [0.2, 0.3].map(|walk| study(walk, 0.9)).to_vec(),
    };
    let all = written_with(&mut subjects, &[earlier]);
    for figure in ["figures/sweep.svg", "figures/cost-of-transport.svg"] {
        let svg = text(&all[figure]);
        for name in ["paper (2 seeds)", "g (2 seeds)"] {
            assert_eq!(
                svg.matches(&format!(">{name}</text>")).count(),
                1,
                "{figure}"
            );
        }
        assert!(!svg.contains("without phase I"), "{figure}");
        assert!(!svg.contains("paper, seed"), "{figure}");
        // Bands, and thin lines below thick ones.
        assert!(svg.contains("fill-opacity=\"0.18\""), "{figure}");
        assert!(svg.contains("stroke-width=\"0.6\"") && svg.contains("stroke-width=\"2.2\""));
    }
    // What leaves out a part stands beside its method, in figures of their own.
    for figure in [
        "figures/paper-without-a-part.svg",
        "figures/fig4-phase-one.svg",
    ] {
        let svg = text(&all[figure]);
        for name in ["the method, 2 seeds", "without phase I, one seed"] {
            assert_eq!(
                svg.matches(&format!(">{name}</text>")).count(),
                1,
                "{figure}: {name}"
            );
        }
    }
    assert!(!all.keys().any(|file| file.contains("journal-")));
    // Ten returns from 1.5 to 10.5 within the first 100 000 steps, of which the last fell: their mean, of every seed.
    let table = text(&all["figures/fig4-phase-one.csv"]);
    let rows: Vec<&str> = table.lines().skip(1).collect();
    assert_eq!(
        rows,
        [
            "paper,1,0.0,100000.0,6.0,0.1",
            "paper,2,0.0,100000.0,6.0,0.1",
            "\"paper, without phase I\",3,0.0,100000.0,6.0,0.1"
        ]
    );
}

#[test]
fn what_falls_is_marked() {
    let mut subject = Subject::shipped().unwrap();
    subject.controller.task.termination.pitch_limit_rad = 0.02;
    let all = written(&mut [subject]);
    for figure in ["sweep", "bifurcation", "through-the-change"] {
        let svg = text(&all[&format!("figures/{figure}.svg")]);
        assert!(svg.contains(">fell (over the panel)</text>"), "{figure}");
    }
    let page = text(&all["report.html"]);
    assert!(page.contains("It runs nowhere as the command rises, nowhere as it falls,"));
    assert!(page.contains("Of 6 random starts 6 fell."));
    assert!(page.contains("It does not have both a walk and a run."));
}
