//! `beeline report`: explains a campaign on one page.
//!
//! The page itself is made by [`crate::report`].

use robot_model::compare::{Comparer, EffectWithValues};
use serde_json::json;

use super::compare::{read, warn_if_single_run};
use super::explain::answer_context;
use crate::cli::{Common, ReportArgs};
use crate::error::{Error, Result};
use crate::explain::{
    AnswerContext, effects_with_values, explained, net_changes, next_run_options,
};
use crate::fit_cache::Question;
use crate::model_page::{Workbench, offline_page};
use crate::report::{CampaignReport, to_html, to_svg};
use crate::ui::tell;
use campaign::file::{WriteError, check_writable, write_whole};
use campaign::model::ModelFile;

pub(super) fn run(common: &Common, args: &ReportArgs) -> Result<()> {
    let is_drawing = is_drawing(args)?;
    let output = args.output.display();
    let cannot = |error: &WriteError| {
        Error::new(format_args!("cannot write {output}: {error}"))
            .hint(error.hint("choose another file with -o"))
    };
    // Before the work: a file that cannot be written must not cost the time.
    check_writable(&args.output).map_err(|error| cannot(&error))?;
    if args.drivetrain {
        if is_drawing {
            return Err(Error::new("the report of motors is a page, .html"));
        }
        let page = super::motors::page(&args.campaign)?;
        write_whole(&args.output, page.as_bytes()).map_err(|error| cannot(&error))?;
        tell(common.json, json!({"report": args.output}), format_args!("{output} written"));
        return Ok(());
    }
    let (read, campaign) = read(&args.campaign)?;
    warn_if_single_run(&campaign);
    let cache = args.reuse.cache(common.json);
    if args.interactive {
        let options = next_run_options(common, &read);
        let workbench = Workbench::new(&args.campaign, (read, campaign), options, cache)?;
        let page = offline_page(&workbench, common.json);
        write_whole(&args.output, page.as_bytes()).map_err(|error| cannot(&error))?;
        tell(common.json, json!({"report": args.output}), format_args!("{output} written"));
        return Ok(());
    }
    let model = ModelFile::read_or_empty(&ModelFile::place(&args.campaign))?;
    let catalogue = model.catalogue();
    // Explained from the robot as recorded, whatever effects its model has been given since.
    let in_use: Vec<&str> = model.in_use().iter().map(|entry| entry.id()).collect();
    let question = Question { campaign: &campaign, catalogue: &catalogue, in_model: &in_use };
    let answer = explained(&question, &cache, common.json)?;
    let comparer = Comparer::with_noise(&campaign, answer.compared_by)?;
    let found = effects_with_values(&answer.steps, &catalogue);
    let context = AnswerContext {
        combinations: net_changes(&comparer, &found),
        ..answer_context(common, &args.campaign, (&read, &campaign), &catalogue)
    };
    let before = effects_with_values(&answer.known, &catalogue);
    let after: Vec<EffectWithValues> = before.iter().chain(&found).cloned().collect();
    let comparisons = [comparer.compare(&before), comparer.compare(&after)];
    let paths = [comparer.paths(&before), comparer.paths(&after)];
    let curves = [comparer.curves(&before), comparer.curves(&after)];
    let report = CampaignReport {
        context: &context,
        answer: &answer,
        comparisons: comparisons.each_ref(),
        paths: paths.each_ref().map(Vec::as_slice),
        curves: curves.each_ref().map(Vec::as_slice),
    };
    let page = if is_drawing { to_svg(&report) } else { to_html(&report) };
    write_whole(&args.output, page.as_bytes()).map_err(|error| cannot(&error))?;
    tell(common.json, json!({"report": args.output}), format_args!("{output} written"));
    Ok(())
}

/// Whether the file is to be a drawing; an error if it can be no report.
fn is_drawing(args: &ReportArgs) -> Result<bool> {
    let ending =
        args.output.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    let is_drawing = ending.as_deref() == Some("svg");
    if !is_drawing && ending.as_deref().is_some_and(|ending| ending != "html" && ending != "htm") {
        return Err(Error::new(format_args!(
            "{}: a report is .html, or .svg",
            args.output.display()
        ))
        .hint("a browser prints the page, to PDF as well"));
    }
    if is_drawing && args.interactive {
        return Err(Error::new("a page on which effects are switched is .html")
            .hint("leave --interactive out for a drawing"));
    }
    Ok(is_drawing)
}
