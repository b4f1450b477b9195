//! Contract: the page holds everything and fetches nothing; its links lead to files beside it; names are text, whatever they
//! contain; seeds of one experiment stand together with intervals and their single values, and the first has figures of its own.
//! Every experiment is in one table of claims.

use crate::common::{text, written};
use gaitshift_report::Subject;

#[test]
fn seeds_of_one_experiment_stand_together_on_a_page_that_fetches_nothing() {
    // Two seeds of one experiment and one of the paper's: the shipped controller each time.
    let named = |name: &str, group: &str, seed| Subject {
        name: name.to_owned(),
        group: group.to_owned(),
        seed,
        ..Subject::shipped().unwrap()
    };
    let mine = "an \"experiment\" & more";
    let mut subjects = [
        named("run 1 <b>", mine, 1),
        named("run 2 <b>", mine, 2),
        named("paper, seed 3", "paper", 3),
    ];
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
    assert!(page.contains("<b>an &quot;experiment&quot; &amp; more</b> (seeds 1, 2)"));
    assert!(page.contains("run 1 &lt;b&gt;") && !page.contains("run 1 <b>"));
    // One table of claims, with the paper's own runs and the other experiment beside them, and the values of the seeds.
    assert_eq!(page.matches("it walks at ω<sub>v</sub> = 0<div").count(), 1);
    let walks = page
        .split("it walks at ω<sub>v</sub> = 0<div")
        .nth(1)
        .unwrap();
    let walks = walks.split("</tr>").next().unwrap();
    assert_eq!(walks.matches("✓ holds").count(), 2, "{walks}");
    assert!(
        walks.contains("<div class=\"seeds\">1.00 1.00</div>"),
        "{walks}"
    );
    assert!(
        walks.contains("gaitshift evaluate --controller RUN --omega-v=0"),
        "{walks}"
    );
    // The paper's run learned from fewer updates than the paper's.
    assert!(page.contains("that of paper, seed 3, for example, has one update per 16 steps"));
    // The method that no claim is about is unfolded, the paper's repetition is not.
    assert!(
        page.contains("<details open>\n<summary><b>an")
            && page.contains("<details>\n<summary><b>paper</b> (seed 3)")
    );
    assert!(
        page.contains("2 of 2 <small>[0."),
        "intervals of success rates"
    );
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
        .find(|line| line.contains("Froude number at ω_v = 0") && line.contains("experiment"))
        .unwrap();
    let cells: Vec<&str> = froude.split(',').collect();
    let value = cells
        .iter()
        .position(|cell| cell.starts_with("0.18"))
        .unwrap();
    assert_eq!(cells[value + 1], cells[value]);
    for folder in ["figures/1-run-1--b-", "figures/3-paper--seed-3"] {
        let figure = format!("{folder}/bifurcation.svg");
        assert!(all.contains_key(&figure), "{figure}: {:?}", all.keys());
    }
    assert!(!all.keys().any(|file| file.starts_with("figures/2-")));
    assert!(all.contains_key("figures/sweep.svg"));
}
