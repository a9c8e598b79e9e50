//! Whom the robot obeys: the key in the store, and what makes each start of the robot differ from all others.

use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_time::Instant;
use shared_proto::{Access, Key, Refusal};

use super::Supervisor;
use super::requests::SAVE_EVERY;
use crate::hal::{LinkRecord, Store, StoreError};
use crate::liveness::SafetyTask;

impl<M: RawMutex, S: Store> Supervisor<'_, M, S> {
    /// Lets hosts in, as soon as it is known which; with a change, others from now on. Then the sessions that are
    /// open end.
    pub(super) async fn open_link(&mut self, change: Option<Option<Key>>) -> Result<(), Refusal> {
        self.motors_off()?;
        let record = self.store.link(change);
        let record = self.shared.liveness.while_waiting(SafetyTask::Supervisor, record).await;
        self.admit(record, change.is_some())
    }

    /// The key in use, if it is known whether there is one.
    pub(super) fn key(&self) -> Option<Option<Key>> {
        match self.shared.access.get() {
            Access::Nobody => None,
            Access::Everybody => Some(None),
            Access::Holders { key, .. } => Some(Some(key)),
        }
    }

    /// For holders of a key there is a number by which nothing that was sent before can be sent again: from a count
    /// that the store has kept before the number is used, and from random numbers, where there are any. If both
    /// fail, nobody is let in.
    #[inline(never)]
    fn admit(
        &mut self,
        record: Result<LinkRecord, StoreError>,
        changed: bool,
    ) -> Result<(), Refusal> {
        if changed {
            self.may_save = Instant::now() + SAVE_EVERY;
            record.map_err(|_| Refusal::Store)?;
        }
        let access = match record {
            Ok(LinkRecord { key: Some(key), count }) => {
                self.store_damaged |= count.is_none();
                let random = self.board.random;
                if count.is_none() && random.is_none() {
                    Access::Nobody
                } else {
                    let (count, random) = (count.unwrap_or(0), random.unwrap_or_default());
                    Access::Holders { key, boot: key.boot(&self.board.uid, count, &random) }
                }
            }
            Err(StoreError::UnknownKey) => Access::Nobody,
            // Nothing at all can be read, as on a chip that has no store: there never was a key.
            Ok(LinkRecord { key: None, .. }) | Err(_) => Access::Everybody,
        };
        self.shared.access.set(access);
        Ok(())
    }
}
