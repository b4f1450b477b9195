//! A figure is written where and as its user asks, is the same on every machine (text included), and a
//! wish that cannot be met is an error that says why.

use crate::common::{colour, pixels};
use gaitshift_figures::{Figure, FigureError};

fn square(content: &str) -> Figure {
    Figure {
        svg: format!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="40" height="30">{content}</svg>"#
        ),
    }
}

#[test]
fn png_has_the_scaled_size() {
    let figure = square(r##"<rect width="40" height="30" fill="#123456"/>"##);
    let png = pixels(&figure, 2.5);
    assert_eq!((png.width(), png.height()), (100, 75));
    assert_eq!(colour(&png, 50, 40), [0x12, 0x34, 0x56]);
}

#[test]
fn text_is_drawn_without_installed_fonts() {
    let text = |family: &str| {
        square(&format!(
            r#"<text x="2" y="20" font-family="{family}">ω{}</text>"#,
            '\u{1d65}'
        ))
    };
    let dark = |figure: &Figure| {
        pixels(figure, 1.0)
            .pixels()
            .iter()
            .filter(|pixel| pixel.red() < 128)
            .count()
    };
    assert!(dark(&text("DejaVu Sans, sans-serif")) > 20);
    // A family that may well be installed here is not used: it would not be installed elsewhere.
    assert_eq!(dark(&text("DejaVu Serif")), 0);
}

// A kill while a picture was written left half of it.
#[test]
fn a_picture_takes_the_place_of_the_old_one_when_it_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("returns.svg");
    std::fs::write(&path, "old").unwrap();
    let old = folder.path().join("old.svg");
    // Another name of the file that is there: writing into that would show here.
    std::fs::hard_link(&path, &old).unwrap();
    let figure = square("");
    figure.write(folder.path().join("returns")).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), figure.svg.as_bytes());
    assert_eq!(std::fs::read(&old).unwrap(), b"old");
    let names = std::fs::read_dir(folder.path()).unwrap();
    assert_eq!(names.count(), 3, "svg, png, and the old one");
}

#[test]
fn the_ending_chooses_the_format() {
    let folder = tempfile::tempdir().unwrap();
    let figure = square("");
    let written = |name: &str| {
        let paths = figure.write(folder.path().join(name)).unwrap();
        let names = paths
            .iter()
            .map(|path| path.file_name().unwrap().to_str().unwrap().to_owned());
        names.collect::<Vec<_>>()
    };
    assert_eq!(written("a.svg"), ["a.svg"]);
    assert_eq!(written("b.PNG"), ["b.PNG"]);
    assert_eq!(written("seed.2"), ["seed.2.svg", "seed.2.png"]);
    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_eq!(read("a.svg"), figure.svg.as_bytes());
    for png in ["b.PNG", "seed.2.png"] {
        assert!(read(png).starts_with(b"\x89PNG"));
    }
}

#[test]
fn other_formats_and_unwritable_places_are_errors_that_name_the_path() {
    let folder = tempfile::tempdir().unwrap();
    let error = square("").write(folder.path().join("a.pdf")).unwrap_err();
    assert!(matches!(error, FigureError::Extension { .. }));
    assert!(error.to_string().contains("a.pdf"));
    let error = square("")
        .write(folder.path().join("missing/a.svg"))
        .unwrap_err();
    assert!(matches!(error, FigureError::Write { .. }));
    assert!(error.to_string().contains("missing"));
}

#[test]
fn impossible_scales_and_broken_drawings_are_errors() {
    for scale in [0.0, -1.0, f64::NAN, f64::INFINITY, 21.0] {
        let error = square("").to_png(scale).unwrap_err();
        assert!(
            matches!(error, FigureError::Option { name: "scale", .. }),
            "{scale}: {error}"
        );
    }
    let broken = Figure {
        svg: "<svg".to_owned(),
    };
    assert!(matches!(
        broken.to_png(1.0),
        Err(FigureError::Raster { .. })
    ));
    let huge = r#"<svg xmlns="http://www.w3.org/2000/svg" width="1e5" height="1e5"/>"#;
    let error = Figure {
        svg: huge.to_owned(),
    }
    .to_png(1.0)
    .unwrap_err();
    assert!(error.to_string().contains("smaller scale"));
}

#[test]
fn a_png_says_how_large_it_is() {
    // Journals ask for dots per inch; without them a picture prints at any size.
    let png = square("").to_png(300.0 / 96.0).unwrap();
    let place = png
        .windows(4)
        .position(|bytes| bytes == b"pHYs")
        .expect("a resolution");
    let number = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
    assert_eq!(number(place - 4), 9);
    // 300 dots per inch are 11811 per metre, both ways; the unit is the metre.
    assert_eq!(
        (number(place + 4), number(place + 8), png[place + 12]),
        (11_811, 11_811, 1)
    );
    // It comes before the pixels, and readers accept its checksum.
    assert!(place < png.windows(4).position(|bytes| bytes == b"IDAT").unwrap());
    assert_eq!(number(place + 13), crc32fast::hash(&png[place..place + 13]));
}
