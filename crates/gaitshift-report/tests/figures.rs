//! Contract: every figure stands beside the page as SVG, PNG, CSV and JSON, and on it; a run brings the returns of its episodes.

mod common;
use common::{run, text, written};
use gaitshift_report::Subject;

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
    // Of the episodes from step 8000 on one in three ended in a fall: more than twice the tenth that "almost none" allows.
    let claims = text(&all["claims.csv"]);
    let line = claims
        .lines()
        .find(|line| line.contains("with phase I"))
        .unwrap();
    assert!(line.contains("0.3333") && line.contains("fails"), "{line}");
}
