//! The page and its parts, all of them in the program.

/// One markup for stage, run and replay; what a mode does not have is hidden.
const PAGE: &str = include_str!("../page/page.html");
/// Looks, light and dark.
pub(crate) const STYLE: &str = include_str!("../page/page.css");
/// What a tab shows.
pub(crate) const ICON: &str = include_str!("../page/icon.svg");

/// Scripts of every mode, in the order in which they build on each other.
macro_rules! shared_scripts {
    () => {
        concat!(
            include_str!("../page/words.js"),
            include_str!("../page/track.js"),
            include_str!("../page/biped.js"),
            include_str!("../page/chart.js"),
            include_str!("../page/strips.js"),
            include_str!("../page/show.js")
        )
    };
}

/// The script of a live page.
pub(crate) const fn live_script() -> &'static str {
    concat!(
        shared_scripts!(),
        include_str!("../page/controls.js"),
        include_str!("../page/run.js"),
        include_str!("../page/live.js")
    )
}

/// The script of a replay.
const REPLAY_SCRIPT: &str = concat!(shared_scripts!(), include_str!("../page/replay.js"));

/// A live page: `live`, with the curves of a `run`, or to `watch` only.
pub(crate) fn live_html(mode: &str) -> String {
    let head = r#"<link rel="icon" href="icon.svg"><link rel="stylesheet" href="page.css"><script src="page.js" defer></script>"#;
    fill(mode, "gaitshift", head, "")
}

/// A page that carries its data, styles and scripts in itself. `data` is JSON.
pub(crate) fn replay_page(title: &str, data: &str) -> String {
    let head = format!("<style>{STYLE}</style>");
    // Nothing in the data can end the element it stands in.
    let data = data.replace('<', "\\u003c");
    let tail = format!(
        "<script type=\"application/json\" id=\"data\">{data}</script>\n<script>{REPLAY_SCRIPT}</script>"
    );
    fill("replay", title, &head, &tail)
}

fn fill(mode: &str, title: &str, head: &str, tail: &str) -> String {
    let title = title
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;");
    // The tail comes last: its data may hold anything.
    PAGE.replacen("{{mode}}", mode, 1)
        .replacen("{{title}}", &title, 1)
        .replacen("{{head}}", head, 1)
        .replacen("{{tail}}", tail, 1)
}
