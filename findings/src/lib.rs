//! What `robot-model` finds in a campaign, in sentences and as JSON: for the command, its pages, and programs.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`headline`] | the main finding, in a few sentences |
//! | [`words`] | everything else in words |
//! | [`json`] | the same for programs: keys and shapes that they rely on |
//! | [`quantity`] | numbers with units, read and written |
//! | [`empty_answer`] | an answer in which nothing is found, for tests |
//!
//! Nothing here reads a file, prints, or fits a model.

pub mod empty_answer;
pub mod headline;
pub mod json;
pub mod quantity;
pub mod words;
