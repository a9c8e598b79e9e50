//! `--undo` of the commands that change a robot.

use crate::cli::Common;
use crate::error::{Error, Result};
use crate::port::with_robot;
use crate::undo::{Restorable, Undo, state_folder};

/// Puts back what this computer changed last, saves it, and returns the change.
pub(super) fn last_change<T: Restorable>(common: &Common) -> Result<Undo<T>> {
    if common.port.is_sim() && common.flash.is_none() {
        return Err(Error::new(
            "this simulated robot forgets when the command ends: nothing to undo",
        )
        .hint(
            "give it a memory with --flash FILE, or run `beeline sim --listen` and use that port",
        ));
    }
    let folder = state_folder()?;
    with_robot(&common.port, &common.sim(), async |session, _| {
        let identity = session.identify().await?;
        let undo = Undo::<T>::recall(&folder, &identity)?;
        undo.carry_out(session, &folder, &identity).await?;
        Ok(undo)
    })
}
