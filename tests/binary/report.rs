//! The page of a campaign: does it show what `explain` says that it shows, on a telephone too?

use std::f64::consts::TAU;

use crate::example::{change_column, runs_of};
use crate::temp_folder::TempFolder;

fn page(temp: &TempFolder) -> String {
    temp.run("report robot -o page.html").ok();
    String::from_utf8(temp.read("page.html")).unwrap()
}

/// The value of an attribute of an element's first tag.
fn attribute<'a>(element: &'a str, name: &str) -> &'a str {
    let tag = element.split('>').next().unwrap();
    let value = tag.split_once(&format!(" {name}=\"")).unwrap_or_else(|| panic!("{name}: {tag}")).1;
    value.split('"').next().unwrap()
}

/// All numbers of an attribute.
fn numbers<'a>(element: &'a str, name: &'a str) -> impl Iterator<Item = f64> + 'a {
    let pattern = format!(" {name}=\"");
    let values: Vec<&str> = element.split(&pattern).skip(1).collect();
    values.into_iter().filter_map(|rest| rest.split('"').next().unwrap().parse().ok())
}

/// The drawings of a page.
fn drawings(page: &str) -> Vec<&str> {
    let each = page.split("<svg").skip(1);
    each.map(|rest| rest.split("</svg>").next().unwrap()).collect()
}

#[test]
fn bars_and_intervals_are_drawn_a_second_time_for_a_screen_of_390_px() {
    let temp = TempFolder::new();
    runs_of(&temp, "mystery-robot", &[""], "robot");
    let page = page(&temp);
    assert!(page.contains("<meta name=\"viewport\" content=\"width=device-width"));
    // One of each is hidden.
    let style = page.split("</style>").next().unwrap();
    assert!(style.contains(".only-narrow{display:none}"), "{style}");
    let narrow = style.split("@media screen and (max-width:640px){").nth(1).unwrap();
    assert!(narrow.starts_with(".only-wide{display:none}.only-narrow{display:block}"), "{style}");
    // As wide as the screen, whatever their own units are.
    assert!(style.contains("svg{display:block;width:100%;height:auto"), "{style}");

    let drawings = drawings(&page);
    for drawing in &drawings {
        assert_eq!(attribute(drawing, "viewBox").split(' ').count(), 4, "{drawing}");
    }
    for label in ["Error as effects are added", "Values with 95 percent intervals"] {
        let of = |class: &str| {
            let is = |drawing: &&&str| {
                attribute(drawing, "aria-label") == label
                    && attribute(drawing, "class").split(' ').any(|one| one == class)
            };
            let found: Vec<&&str> = drawings.iter().filter(is).collect();
            assert_eq!(found.len(), 1, "{label}, {class}");
            *found[0]
        };
        let (wide, narrow) = (of("only-wide"), of("only-narrow"));
        // 390 px less the margins of the page: a letter of 13 px stays one.
        let width: f64 = attribute(narrow, "viewBox").split(' ').nth(2).unwrap().parse().unwrap();
        assert!((300.0..=350.0).contains(&width), "{width}");
        assert!(numbers(narrow, "x").all(|x| (0.0..width).contains(&x)), "{narrow}");
        let ends = numbers(narrow, "x").zip(numbers(narrow, "width"));
        assert!(ends.into_iter().all(|(x, w)| x + w <= width || w == width), "{narrow}");
        // Both say the same.
        let words = |drawing: &str| {
            let texts = drawing.split("<text").skip(1);
            let texts = texts.map(|rest| rest.split("</text>").next().unwrap());
            texts.filter(|text| !text.contains("class=\"tick\"")).count()
        };
        assert_eq!(words(wide), words(narrow), "{label}");
    }
}

#[test]
fn what_depends_on_the_place_is_drawn_against_the_place() {
    let temp = TempFolder::new();
    runs_of(&temp, "optiodom", &["ivanjko"], "robot");
    let answer = temp.run("explain robot --json").ok().json();
    let depends_on = answer["unexplained"]["depends_on"].as_array().unwrap();
    assert!(depends_on.iter().any(|name| name == "place"), "{answer:#}");
    let page = page(&temp);
    assert!(page.contains("aria-label=\"The floor, and the place that the residuals depend on\""));
    // And each variable that it depends on has a drawing, marked as such.
    for (name, axis) in [("turn rate", "turn rate in rad/s"), ("wheel angle", "angle of the left")]
    {
        if depends_on.iter().any(|other| other == name) {
            let panel = page.split(&format!("<b>Against {axis}")).nth(1);
            let panel = panel.unwrap_or_else(|| panic!("{name}: {answer:#}"));
            let caption = panel.split("</figcaption>").next().unwrap();
            assert!(caption.contains("the residuals depend on it"), "{name}: {caption}");
        }
    }
}

#[test]
fn no_page_says_that_no_further_run_is_needed_while_something_is_unexplained() {
    let temp = TempFolder::new();
    runs_of(&temp, "mystery-robot", &[""], "robot");
    // An encoder that leads and lags five times a turn, by 8 of 900 counts: no effect of the catalogue does.
    let ripple = |counts: f64| (counts + 8.0 * (5.0 * TAU * counts / 900.0).sin()).round();
    change_column(&temp, "robot", "left_counts", |counts| ripple(counts).to_string());
    let said = temp.run("explain robot").ok().stdout;
    assert!(said.contains("Still unexplained: the residuals depend on wheel angle"), "{said}");
    let page = page(&temp);
    for text in [&said, &page] {
        assert!(text.contains("No run can be suggested for what is still unexplained"), "{text}");
        assert!(!text.contains("No further run is needed"), "{text}");
    }
    let panel = page.split("<b>Against angle of the left wheel").nth(1).unwrap();
    let caption = panel.split("</figcaption>").next().unwrap();
    assert!(caption.contains("the residuals depend on it"), "{caption}");
}

/// On a terminal, what was found so far is shown; in a pipe, nothing but warnings.
#[cfg(unix)]
#[test]
fn explain_shows_on_a_terminal_what_it_found_so_far() {
    use std::io::Read;
    use std::process::Stdio;
    use std::time::Duration;

    use serialport::{SerialPort, TTYPort};

    let temp = TempFolder::new();
    runs_of(&temp, "mystery-robot", &["out_and_back", "spin", "arc_large"], "robot");
    let (mut terminal, inner) = TTYPort::pair().unwrap();
    terminal.set_timeout(Duration::from_secs(1)).unwrap();
    let open = |name: &str| std::fs::OpenOptions::new().read(true).write(true).open(name).unwrap();
    let mut child = temp
        .command(&["explain", "robot"])
        .env("TERM", "xterm")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(open(&inner.name().unwrap()))
        .spawn()
        .unwrap();
    let mut shown = Vec::new();
    let mut buffer = [0; 4096];
    loop {
        let ended = child.try_wait().unwrap();
        match terminal.read(&mut buffer) {
            Ok(length) => shown.extend_from_slice(&buffer[..length]),
            Err(_) if ended.is_some() => break,
            Err(_) => {}
        }
    }
    assert!(child.wait().unwrap().success());
    let shown = String::from_utf8_lossy(&shown);
    let mut rest = &shown[..];
    for words in [
        "reading and checking the runs",
        "checked",
        "clocks of poses and wheels agree",
        "radius, ratio, track: ",
        "wheel radius grows with speed: ",
    ] {
        let at = rest.find(words).unwrap_or_else(|| panic!("{words}, in order: {shown}"));
        rest = &rest[at..];
    }
    let piped = temp.run("explain robot").ok().stderr;
    assert!(!piped.contains("checked") && !piped.contains("radius, ratio"), "{piped}");
}
