use robot_model::compare::{Axis, Bin, Comparison, Curve, Drift, ErrorLevel, Finding, Path, Rms};
use robot_model::effect::CATALOGUE;
use robot_model::estimation::{ErrorPair, Errors};
use robot_model::explain::{
    CandidateKind, Evidence, HeldOut, NextRun, ParameterFound, PredictedSeparation, Reason,
    Rejected, StepFound,
};
use robot_model::recording::RunKind;
use robot_model::residuals::{PlaceSeen, Regressor, Unexplained};

use super::*;
use crate::explain::AnswerContext;
use findings::empty_answer::nothing_found;

fn errors(mm: f64) -> Errors {
    Errors { position_rms_m: mm * 1e-3, heading_rms_rad: mm * 2e-3, chi: 1.2 }
}

fn answer() -> Answer {
    let parameter = |value: f64| ParameterFound {
        name: "k".into(),
        unit: "s".into(),
        value,
        sigma: 0.001,
        low95: value - 0.002,
        high95: value + 0.002,
    };
    let pair = |mm: f64| ErrorPair { fitted: errors(0.9 * mm), cross_validated: errors(mm) };
    Answer {
        baseline: pair(25.8),
        steps: vec![StepFound {
            effect: "side_slip".into(),
            class: vec!["side_slip".into(), "measurement_delay".into()],
            parameters: vec![parameter(0.02)],
            fitted: errors(5.0),
            cross_validated: errors(6.0),
            p_value: 1e-9,
            evidence: Evidence { signature: "it is <b>there</b>".into(), ..Evidence::default() },
            effect_size_m: 1e-2,
            least_size_m: 1e-2,
            moves_no_track: false,
            nears_runs: true,
            used_to_predict: true,
            matters: true,
        }],
        rejected: vec![Rejected {
            effect: "scrub".into(),
            reason: Reason::NotShown { shown_by: "no & never".into() },
            cross_validated: errors(7.0),
        }],
        unexplained: Unexplained {
            structure: true,
            depends_on: vec![Regressor::Speed],
            p_value: 0.001,
            size_m: 3e-3,
            ..Unexplained::default()
        },
        held_out: Some(HeldOut {
            runs: 2,
            kinds: vec![RunKind::Square],
            baseline: errors(12.3),
            model: errors(4.5),
        }),
        next_run: Some(NextRun {
            kind: CandidateKind::SpinsBothWays,
            separates: vec!["side_slip".into()],
            predicted: PredictedSeparation::default(),
        }),
        reachable: errors(5.0),
        ..nothing_found()
    }
}

fn html(robot: &str, broken: bool) -> String {
    drawn(robot, broken, to_html)
}

fn drawn(robot: &str, broken: bool, draw: fn(&CampaignReport<'_>) -> String) -> String {
    drawn_of(robot, broken, draw, &answer())
}

fn drawn_of(
    robot: &str,
    broken: bool,
    draw: fn(&CampaignReport<'_>) -> String,
    answer: &Answer,
) -> String {
    let rms = Rms { rms: 0.02, noise: 0.002, noise_high: 0.003 };
    let comparison = Comparison {
        finding: Finding { nominal: true, error_level: ErrorLevel::WithinNoise, worst: None },
        position_m: rms,
        heading_rad: rms,
        held_out: None,
        runs: Vec::new(),
        regimes: Vec::new(),
    };
    let bad = if broken { f64::NAN } else { 0.5 };
    let path = Path {
        run: "01_<a>".into(),
        kind: RunKind::Arc,
        held_out: true,
        measured_m: vec![[0.0, 0.0], [1.0, bad], [1.5, 0.2]],
        predicted_m: vec![[0.0, 0.0], [1.0, 0.51], [1.5, 0.25]],
        way_m: Vec::new(),
    };
    let ends = Path {
        run: "02_ends".into(),
        held_out: false,
        measured_m: vec![[0.0, 0.0], [0.0, bad]],
        predicted_m: vec![[0.0, 0.0], [0.01, 0.52]],
        way_m: vec![[0.0, 0.0], [0.3, 0.1], [0.3, 0.4], [0.01, bad]],
        ..path.clone()
    };
    let paths = [path, ends];
    let drift = Drift { component: Component::Turn, per_m: 0.002, sigma: 0.0005 };
    let bins = (0..4).map(|k| Bin { at: f64::from(k), drift }).collect();
    let curve = Curve { axis: Axis::Speed, component: Component::Turn, bins, chi: 4.0 };
    let context = AnswerContext {
        robot,
        campaign: "my robot".into(),
        robot_options: "--port sim".into(),
        runs: ["a", "b", "c"].map(str::to_owned).to_vec(),
        motions: vec![0, 1, 2],
        catalogue: &CATALOGUE,
        combinations: vec![Some("2.0 mm to the left per metre".into())],
        in_model: &[],
        nominal_m: [0.036, 0.372],
    };
    draw(&CampaignReport {
        context: &context,
        answer,
        comparisons: [&comparison, &comparison],
        paths: [&paths, &paths],
        curves: [std::slice::from_ref(&curve), std::slice::from_ref(&curve)],
    })
}

use robot_model::compare::Component;

#[test]
fn the_title_counts_what_the_first_sentence_calls_missing() {
    let mut answer = answer();
    assert_eq!(title(&answer), "One effect is missing");
    // It may be something else.
    answer.steps[0].used_to_predict = false;
    assert_eq!(title(&answer), "An unknown effect");
}

#[test]
fn the_page_needs_nothing_but_itself_and_names_stay_text() {
    let page = html("<script>alert(1)</script>", false);
    for foreign in ["http", "<script", "src=", "@import", "url(", "<link", "<b>there", "<a>"] {
        assert!(!page.contains(foreign), "{foreign}");
    }
    assert!(page.contains("&lt;script&gt;"));
    assert_eq!(page, html("<script>alert(1)</script>", false), "the same bytes");
}

#[test]
fn runs_kept_aside_have_their_errors_and_are_marked() {
    let page = html("robot", false);
    let words = "On the 2 held-out runs (square), used neither to fit nor to select";
    assert!(
        page.contains(words) && page.contains("12.3 mm, 24.6 mrad</span> for the nominal robot")
    );
    assert!(page.contains("01_&lt;a&gt;, held out</b>"), "{page}");
}

#[test]
fn elements_are_closed_and_no_coordinate_is_nan() {
    let pictures = [false, true].map(|broken| drawn("Bee", broken, to_svg));
    for page in [html("Bee", false), html("Bee", true)].iter().chain(&pictures) {
        assert!(!page.contains("NaN") && !page.contains("inf\""), "a number that is none");
        for tag in
            ["svg", "g", "style", "table", "tr", "td", "div", "text", "p", "h2", "span", "figure"]
        {
            let opened = page.matches(&format!("<{tag}>")).count()
                + page.matches(&format!("<{tag} ")).count();
            assert_eq!(opened, page.matches(&format!("</{tag}>")).count(), "{tag}");
        }
    }
}

#[test]
fn the_page_says_what_explain_says() {
    let page = html("Bee", false);
    for words in [
        "One effect is missing",
        "<span class=\"before\">25.8 mm</span> without, <span class=\"after\">6.0 mm</span> with",
        "from 25.8 mm, 51.6 mrad to 6.0 mm, 12.0 mrad",
        "These runs cannot tell side_slip and measurement_delay apart. Their combined effect: 2.0 mm to the left",
        "The residuals depend on <b>speed</b>",
        "beeline campaign record &#39;my robot&#39; --run &#39;spins both ways&#39; --port sim",
        "no &amp; never",
        "20.0 \u{b1} 1.0 ms",
    ] {
        assert!(page.contains(words), "{words}");
    }
}

#[test]
fn a_run_of_which_the_ends_were_measured_has_its_way_by_the_model_and_two_dots() {
    let page = html("Bee", false);
    let drawn = page.split("aria-label=\"Path of 02_ends\"").nth(1).unwrap();
    let drawn = drawn.split("</svg>").next().unwrap();
    assert_eq!(drawn.matches("class=\"dot\"").count(), 2, "{drawn}");
    assert_eq!(drawn.matches("<path class=\"p ").count(), 2, "{drawn}");
    let other = page.split("aria-label=\"Path of 01_").nth(1).unwrap();
    assert!(!other.split("</svg>").next().unwrap().contains("class=\"dot\""));
}

#[test]
fn a_place_that_is_named_is_drawn_on_the_floor() {
    assert!(!html("Bee", false).contains("aria-label=\"The floor"));
    let mut answer = answer();
    answer.unexplained.depends_on = vec![Regressor::Place];
    answer.unexplained.place_m = Some([0.6, -0.22]);
    let seen = |x_m: f64, gain: f64| PlaceSeen { at_m: [x_m, -0.3], gain };
    answer.unexplained.places = vec![seen(0.6, 200.0), seen(0.9, 20.0), seen(-3.0, -1.0)];
    for broken in [false, true] {
        let page = drawn_of("Bee", broken, to_html, &answer);
        let floor = page.split("aria-label=\"The floor").nth(1).unwrap();
        let floor = floor.split("</figure>").next().unwrap();
        assert!(floor.contains(">x 0.60 m, y \u{2212}0.22 m</text>"), "{floor}");
        assert_eq!(floor.matches("<rect ").count(), 2, "what explains nothing is not drawn");
        for opacity in ["\"0.80\"", "\"0.08\""] {
            assert!(floor.contains(&format!("fill-opacity={opacity}")), "{opacity}: {floor}");
        }
        assert!(!floor.contains("NaN"));
    }
}

#[test]
fn a_dependence_on_the_place_is_drawn_though_no_single_place_stands_out() {
    let mut answer = answer();
    answer.unexplained.depends_on = vec![Regressor::Place];
    answer.unexplained.places = vec![PlaceSeen { at_m: [0.6, -0.3], gain: 20.0 }];
    let page = drawn_of("Bee", false, to_html, &answer);
    let floor = page.split("aria-label=\"The floor").nth(1).unwrap();
    let floor = floor.split("</figure>").next().unwrap();
    assert_eq!((floor.matches("<rect ").count(), floor.matches("<circle ").count()), (1, 0));
    assert!(page.contains("No single place stands out."), "{page}");
}

#[test]
fn the_picture_alone_has_the_falling_error_and_a_run() {
    let svg = drawn("Bee & Co", false, to_svg);
    assert!(
        svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\"") && svg.ends_with("</svg>\n")
    );
    for words in ["One effect is missing", "Bee &amp; Co, 3 runs", "25.8", "6.0", "01_&lt;a&gt;"] {
        assert!(svg.contains(words), "{words}: {svg}");
    }
}
