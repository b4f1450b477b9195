//! What one controller does over the whole range of its command.

use gaitshift_analysis::{GaitClass, GaitSummary};

use crate::canvas::{Canvas, Ink, Paint, Point, Rect};
use crate::chart::{Axis, Panel};
use crate::legend::{Spacing, places};
use crate::raster::fitting;
use crate::style::{LABEL, PAPER, QUIET, SERIES, SMALL, TEXT, TITLE, WHITE};
use crate::{Figure, FigureError};

/// One evaluated command, of one motion or the mean of several. What is undefined for the motion is `None` and left out of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SweepPoint {
    /// Command `ω_v`.
    pub omega_v: f64,
    /// Whether the body fell, or of several fell once or more; drawn hollow.
    pub fell: bool,
    /// What the motion is, where it is one thing. A line joins neighbouring commands of one gait only.
    pub gait: Option<GaitClass>,
    /// Mean forward speed in m/s.
    pub speed_m_per_s: Option<f64>,
    /// Froude number `v / √(g l)`.
    pub froude: Option<f64>,
    /// Cost of transport (8) of the paper.
    pub cost_of_transport: Option<f64>,
    /// Share of time with both feet on the ground, in [0, 1].
    pub double_support: Option<f64>,
    /// Share of time with one foot on the ground, in [0, 1].
    pub single_support: Option<f64>,
    /// Share of time with no foot on the ground, in [0, 1].
    pub flight: Option<f64>,
    /// Of a mean, the standard deviations of the six quantities above, in their order; drawn as bars.
    pub deviations: [Option<f64>; 6],
}

impl SweepPoint {
    /// What the analysis says of the motion recorded at `omega_v`.
    pub fn new(omega_v: f64, summary: &GaitSummary) -> Self {
        Self {
            omega_v,
            fell: summary.fell,
            gait: Some(summary.gait),
            speed_m_per_s: summary.speed_m_per_s,
            froude: summary.froude,
            cost_of_transport: summary.cost_of_transport,
            double_support: summary.double_support,
            single_support: summary.single_support,
            flight: summary.flight,
            deviations: [None; 6],
        }
    }
}

/// The points of one controller, or of one seed, under a name.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepSeries {
    /// Name in the legend.
    pub label: String,
    /// Points, joined in the order of `ω_v` where neighbours are of one gait.
    pub points: Vec<SweepPoint>,
}

impl SweepPoint {
    /// Whether a line may lead on to the next command: between gaits, through motions that are none and to falls there is
    /// nothing that it could stand for.
    fn leads_to(&self, next: &Self) -> bool {
        let steady = |point: &Self| !point.fell && point.gait != Some(GaitClass::Mixed);
        steady(self) && steady(next) && self.gait.is_some() && self.gait == next.gait
    }
}

/// Of a point, the quantity that a panel shows.
type Quantity = fn(&SweepPoint) -> Option<f64>;

struct PanelKind {
    title: &'static str,
    of: Quantity,
    /// The paper's values as (ω_v, value). Speeds follow from its Froude numbers, g = 9.81 m/s² and
    /// l = 0.8 m.
    paper: &'static [(f64, f64)],
    is_share: bool,
}

const PANELS: [PanelKind; 6] = [
    PanelKind {
        title: "speed (m/s)",
        of: |point| point.speed_m_per_s,
        paper: &[(0.0, 0.616), (3.0, 2.605)],
        is_share: false,
    },
    PanelKind {
        title: "Froude number",
        of: |point| point.froude,
        paper: &[(0.0, 0.22), (3.0, 0.93)],
        is_share: false,
    },
    PanelKind {
        title: "cost of transport",
        of: |point| point.cost_of_transport,
        paper: &[(0.0, 0.342), (3.0, 0.347)],
        is_share: false,
    },
    PanelKind {
        title: "double support",
        of: |point| point.double_support,
        paper: &[],
        is_share: true,
    },
    PanelKind {
        title: "single support",
        of: |point| point.single_support,
        paper: &[],
        is_share: true,
    },
    PanelKind {
        title: "flight",
        of: |point| point.flight,
        paper: &[],
        is_share: true,
    },
];

/// Speed, Froude number, cost of transport and the shares of double support, single support and flight
/// against the command `ω_v`, the paper's values marked by diamonds.
///
/// # Errors
/// [`FigureError::Empty`] without any point, [`FigureError::NotFinite`] for a value that cannot be drawn.
pub fn sweep_figure(series: &[SweepSeries]) -> Result<Figure, FigureError> {
    let points = || series.iter().flat_map(|series| &series.points);
    if points().next().is_none() {
        return Err(FigureError::Empty {
            what: "the sweep",
            needed: "one command",
        });
    }
    for (index, point) in points().enumerate() {
        let means = PANELS.iter().map(|kind| (kind.title, (kind.of)(point)));
        let deviations = PANELS.iter().map(|kind| kind.title).zip(point.deviations);
        let quantities = means.chain(deviations);
        for (name, value) in quantities.chain([("omega_v", Some(point.omega_v))]) {
            if let Some(value) = value.filter(|value| !value.is_finite()) {
                return Err(FigureError::NotFinite {
                    name: name.to_owned(),
                    index,
                    value,
                });
            }
        }
    }

    let (width, height, gap) = (172.0, 126.0, 52.0);
    let left = 44.0;
    let sheet_width = left + 3.0 * width + 2.0 * gap + 14.0;
    let legend = Legend::new(series, left, sheet_width);
    let top = 35.0 + legend.height;
    let sheet = (sheet_width, top + 2.0 * height + gap + 44.0);
    let mut canvas = Canvas::new(sheet.0, sheet.1);
    legend.draw(&mut canvas);
    let x = Axis::around(points().map(|point| point.omega_v).chain([0.0, 3.0]), 5);
    for (i, kind) in PANELS.iter().enumerate() {
        let (column, row) = ((i % 3) as f64, (i / 3) as f64);
        let area = Rect::new(
            left + column * (width + gap),
            top + row * (height + gap),
            width,
            height,
        );
        let values = points().flat_map(|point| {
            let deviation = point.deviations[i].unwrap_or(0.0);
            [-deviation, deviation].map(|by| (kind.of)(point).map(|value| value + by))
        });
        let values = values.flatten();
        let y = if kind.is_share {
            Axis::exact(-0.03, 1.03, 5)
        } else {
            Axis::around(values.chain(kind.paper.iter().map(|p| p.1)).chain([0.0]), 4)
        };
        let panel = Panel {
            area,
            x: x.clone(),
            y,
        };
        panel.grid(&mut canvas);
        canvas.text((area.left, area.top - 7.0), kind.title, TITLE);
        for (series, ink) in series.iter().zip(SERIES.into_iter().cycle()) {
            draw_series(&mut canvas, &panel, series, (i, kind.of), ink);
        }
        for &(omega_v, value) in kind.paper {
            diamond(&mut canvas, panel.place(omega_v, value));
        }
        panel.frame(&mut canvas, true);
        if row > 0.0 {
            panel.x_title(&mut canvas, "command ω\u{1d65} (s/m)");
        }
    }
    Ok(Figure {
        svg: canvas.finish(),
    })
}

fn draw_series(
    canvas: &mut Canvas,
    panel: &Panel,
    series: &SweepSeries,
    (index, of): (usize, Quantity),
    ink: Ink,
) {
    let mut points: Vec<&SweepPoint> = series.points.iter().collect();
    points.sort_by(|a, b| a.omega_v.total_cmp(&b.omega_v));
    for part in points.chunk_by(|point, next| point.leads_to(next) && of(next).is_some()) {
        let (xs, ys): (Vec<f64>, Vec<f64>) = part
            .iter()
            .filter_map(|point| Some((point.omega_v, of(point)?)))
            .unzip();
        if xs.len() > 1 {
            panel.curve(canvas, &xs, &ys, Paint::stroke(ink, 1.4));
        }
    }
    for point in points {
        let Some(y) = of(point) else { continue };
        if let Some(deviation) = point.deviations[index] {
            let [low, high] = [-deviation, deviation].map(|by| panel.place(point.omega_v, y + by));
            canvas.line(low, high, Paint::stroke(ink, 1.2));
        }
        let fill = if point.fell { WHITE } else { ink };
        let place = panel.place(point.omega_v, y);
        canvas.circle(place, 3.0, Paint::fill(fill).outlined(ink, 1.2));
    }
}

/// The paper's mark.
fn diamond(canvas: &mut Canvas, (x, y): Point) {
    let half = 5.5;
    let corners = [(x, y - half), (x + half, y), (x, y + half), (x - half, y)];
    canvas.polygon(corners, Paint::fill(PAPER).outlined(TEXT, 0.9));
}

/// Entries of the legend, each with its place; longer ones than the sheet is wide go on in the next row.
struct Legend {
    entries: Vec<(String, Point, Mark)>,
    height: f64,
}

#[derive(Clone, Copy)]
enum Mark {
    Series(Ink),
    Paper,
    Fell,
    Deviation,
}

impl Legend {
    const SPACING: Spacing = Spacing {
        name: 16.0,
        gap: 16.0,
        row: 17.0,
    };

    fn new(series: &[SweepSeries], left: f64, right: f64) -> Self {
        let inks = SERIES.into_iter().cycle().map(Mark::Series);
        let names = series.iter().map(|series| series.label.as_str()).zip(inks);
        let points = || series.iter().flat_map(|s| &s.points);
        let fell = points().any(|point| point.fell);
        let several = points().any(|point| point.deviations.iter().any(Option::is_some));
        let of_fallen = if several { "one or more fell" } else { "fell" };
        let fixed = [("the paper", Mark::Paper)];
        let rest = fixed
            .into_iter()
            .chain(several.then_some(("mean over starts ± standard deviation", Mark::Deviation)))
            .chain(fell.then_some((of_fallen, Mark::Fell)));
        let width = right - left - Self::SPACING.gap;
        let (names, marks): (Vec<String>, Vec<Mark>) = names
            .chain(rest)
            .map(|(name, mark)| (fitting(name, SMALL, width - Self::SPACING.name), mark))
            .unzip();
        let (places, height) = places(names.iter().map(String::as_str), Self::SPACING, width);
        let places = places.into_iter().map(|(x, y)| (left + x, 19.0 + y));
        let entries = names.into_iter().zip(places).zip(marks);
        Self {
            entries: entries
                .map(|((name, place), mark)| (name, place, mark))
                .collect(),
            height,
        }
    }

    fn draw(&self, canvas: &mut Canvas) {
        for (name, (x, base), mark) in &self.entries {
            canvas.text((x + Self::SPACING.name, *base), name, LABEL);
            let place = (x + 6.0, base - 4.0);
            match mark {
                Mark::Series(ink) => canvas.circle(place, 3.5, Paint::fill(*ink)),
                Mark::Paper => diamond(canvas, place),
                Mark::Deviation => {
                    let (x, y) = place;
                    canvas.line((x, y - 6.0), (x, y + 6.0), Paint::stroke(QUIET, 1.2));
                    canvas.circle(place, 3.0, Paint::fill(QUIET));
                }
                Mark::Fell => canvas.circle(place, 3.0, Paint::fill(WHITE).outlined(QUIET, 1.2)),
            }
        }
    }
}
