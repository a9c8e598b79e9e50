//! The page as one file: what it may ask is answered in it, so it needs no server.
//!
//! It holds the nominal robot, the effects found, every effect alone, and the effects found with one more or one less.
//! Each takes some tens of kilobytes, and a tenth of a second to fit.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::request::ModelRequest;
use super::workbench::Workbench;
use crate::page_server::Page;
use crate::ui::Progress;

/// The page.
pub(super) const PAGE: Page = Page {
    html: include_str!("assets/page.html"),
    css: include_str!("assets/page.css"),
    scripts: &[
        ("source.js", include_str!("assets/source.js")),
        ("numbers.js", include_str!("assets/numbers.js")),
        ("paths.js", include_str!("assets/paths.js")),
        ("curves.js", include_str!("assets/curves.js")),
        ("effects.js", include_str!("assets/effects.js")),
        ("page.js", include_str!("assets/page.js")),
    ],
};

/// What a file may do: run its own scripts, and ask nobody.
const POLICY: &str = "<meta http-equiv=\"Content-Security-Policy\" \
    content=\"default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:\">\n";

/// The page with everything in it.
pub fn offline_page(workbench: &Workbench, quiet: bool) -> String {
    workbench.explain();
    let campaign = workbench.campaign();
    let mut explanation = workbench.explanation();
    // Lines for who waits; a fit that is reused has none.
    explanation["found"] = json!([]);
    let models = models(workbench, &requests(&campaign, &explanation), quiet);
    let recorded = json!({"campaign": campaign, "explanation": explanation, "models": models});
    // `</script>` in a name would end the script.
    let recorded = recorded.to_string().replace('<', "\\u003c");
    let mut page = PAGE.html.replace("<head>\n", &format!("<head>\n{POLICY}"));
    let link = "<link rel=\"stylesheet\" href=\"page.css\">";
    page = page.replace(link, &format!("<style>\n{}</style>", PAGE.style()));
    for (name, text) in PAGE.scripts {
        let tag = format!("<script defer src=\"{name}\"></script>\n");
        debug_assert!(page.contains(&tag), "{name}");
        page = page.replace(&tag, "");
        // At the end, as `defer` has it.
        page = page.replace("</body>", &format!("<script>\n{text}</script>\n</body>"));
    }
    let data = format!("<script type=\"application/json\" id=\"recorded\">{recorded}</script>\n");
    page.replacen("<main", &format!("{data}<main"), 1)
}

/// The sets of effects that are fitted, each once, in the order of the catalogue.
fn requests(campaign: &Value, explanation: &Value) -> Vec<Vec<String>> {
    let ids = |list: &Value, key: &str| -> Vec<String> {
        let list = list.as_array().into_iter().flatten();
        list.filter_map(|of| Some(of[key].as_str()?.to_owned())).collect()
    };
    let catalogue = ids(&campaign["catalogue"], "id");
    let found = ids(&explanation["answer"]["steps"], "effect");
    let own = campaign["model"].as_array().into_iter().flatten();
    let own: Vec<String> = own.filter_map(|id| Some(id.as_str()?.to_owned())).collect();
    let mut sets: Vec<Vec<String>> = vec![Vec::new()];
    for start in [Vec::new(), found, own] {
        // As the effects were found, one after another.
        sets.extend((1..=start.len()).map(|count| start[..count].to_vec()));
        for id in &catalogue {
            let mut other = start.clone();
            match other.iter().position(|known| known == id) {
                Some(at) => drop(other.remove(at)),
                None => other.push(id.clone()),
            }
            sets.push(other);
        }
    }
    let rank = |id: &String| catalogue.iter().position(|known| known == id);
    sets.iter_mut().for_each(|set| set.sort_by_key(rank));
    let mut once: Vec<Vec<String>> = Vec::new();
    for set in sets {
        if !once.contains(&set) {
            once.push(set);
        }
    }
    once
}

fn models(workbench: &Workbench, sets: &[Vec<String>], quiet: bool) -> BTreeMap<String, Value> {
    let progress = Progress::new("fitting models", quiet);
    let mut models = BTreeMap::new();
    for (number, set) in sets.iter().enumerate() {
        progress.set(number as f64 / sets.len() as f64);
        let ids: Vec<&str> = set.iter().map(String::as_str).collect();
        let answer = match workbench.model_answer(&ModelRequest::fitted(&ids)) {
            Ok(answer) => (*answer).clone(),
            Err(problem) => json!({"error": problem}),
        };
        models.insert(set.join(","), answer);
    }
    models
}
