//! The robot's state.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};


