//! Contract: the page holds everything and fetches nothing; its links lead to files beside it; names are text, whatever they
//! contain; seeds of one experiment stand together with intervals, and each has figures of its own.

mod common;
use common::{text, written};
use gaitshift_report::Subject;

#[test]
fn seeds_of_one_experiment_stand_together_on_a_page_that_fetches_nothing() {
    // Two seeds of one experiment: the shipped controller and itself.
    let mut subjects: Vec<Subject> = (1..=2)
        .map(|seed| Subject {
            name: format!("run {seed} <b>"),
            group: "an \"experiment\" & more".to_owned(),
            seed,
            ..Subject::shipped().unwrap()
        })
        .collect();
    let all = written(&mut subjects);
    let page = text(&all["report.html"]);
    for fetching in ["src=", "@import", "url(", "<script", "<link"] {
        assert!(!page.contains(fetching), "{fetching}");
    }
    for (at, _) in page.match_indices("href=\"") {
        let target = page[at + 6..].split('"').next().unwrap();
        let known = target.starts_with('#') && page.contains(&format!("id=\"{}\"", &target[1..]));
        assert!(known || all.contains_key(target), "{target}");
    }
    assert!(!page.contains("NaN") && !page.contains("inf<"));
    assert!(page.contains("an &quot;experiment&quot; &amp; more (seeds 1, 2)"));
    assert!(page.contains("run 1 &lt;b&gt;") && !page.contains("run 1 <b>"));
    // Every row has as many cells as its table has columns.
    for table in page.split("<table").skip(1) {
        let table = table.split("</table>").next().unwrap();
        let columns = table.matches("<th>").count() + table.matches("<th ").count();
        for row in table.split("<tr>").skip(2) {
            let cells = row.matches("<td>").count() + row.matches("<td ").count();
            assert_eq!(cells, columns, "{row}");
        }
    }

    // Intervals, which a single seed has not: both values are the same here.
    let claims = text(&all["claims.csv"]);
    let froude = claims
        .lines()
        .find(|line| line.contains("Froude number at ω_v = 0"))
        .unwrap();
    let cells: Vec<&str> = froude.split(',').collect();
    let value = cells
        .iter()
        .position(|cell| cell.starts_with("0.17"))
        .unwrap();
    assert_eq!(cells[value + 1], cells[value]);
    for folder in ["figures/1-run-1--b-", "figures/2-run-2--b-"] {
        assert!(
            all.contains_key(&format!("{folder}/bifurcation.svg")),
            "{folder}"
        );
    }
    assert!(all.contains_key("figures/sweep.svg"));
}
