//! What does a TOML file hold, or where is it wrong?

use std::path::Path;

use serde::de::DeserializeOwned;

use crate::error::{CampaignError, Place};

/// Reads the text of a TOML file; an error has its place in it, and `hint` makes what to do of the problem.
pub fn parse_toml<T: DeserializeOwned>(
    file: &Path,
    text: &str,
    hint: impl FnOnce(&str) -> &'static str,
) -> Result<T, CampaignError> {
    toml::from_str(text).map_err(|error| {
        let place = error
            .span()
            .map_or_else(|| Place::whole(file), |span| Place::of_byte(file, text, span.start));
        let problem = error.message().trim().replace('\n', "; ");
        let hint = hint(&problem);
        CampaignError::new(place, problem, hint)
    })
}
