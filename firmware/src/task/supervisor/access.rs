//! Whom the robot obeys: the key in the store, and what makes each start of the robot differ from all others.

use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_time::{Instant, Timer};
use shared_proto::{Key, Refusal};

use super::Supervisor;
use super::requests::SAVE_EVERY;
use crate::hal::{Store, StoreError};
use crate::liveness::SafetyTask;
use crate::shared::Access;

impl<M: RawMutex, S: Store> Supervisor<'_, M, S> {
    /// Lets hosts in, as soon as it is known which.
    pub(super) async fn open_link(&mut self) {
        let key = self.store.key();
        let access = match self.shared.liveness.while_waiting(SafetyTask::Supervisor, key).await {
            Ok(Some(key)) => self.holders(key).await,
            // Nothing at all can be read, as on a chip that has no store: there never was a key.
            Ok(None) | Err(StoreError::Damaged | StoreError::Write) => Access::Everybody,
            Err(StoreError::UnknownKey) => Access::Nobody,
        };
        self.shared.access.set(access);
    }

    /// Keeps another key. The sessions that are open end with the old one.
    pub(super) async fn set_key(&mut self, key: Option<Key>) -> Result<(), Refusal> {
        self.motors_off()?;
        let store = &mut self.store;
        let save = async {
            Timer::at(self.may_save).await;
            // A host that repeats the request must not wear out the flash.
            if store.key().await == Ok(key) {
                return Ok(false);
            }
            store.set_key(key).await.map(|()| true)
        };
        let changed = self.shared.liveness.while_waiting(SafetyTask::Supervisor, save).await;
        if changed.map_err(|_| Refusal::Store)? {
            self.may_save = Instant::now() + SAVE_EVERY;
            let access = match key {
                Some(key) => self.holders(key).await,
                None => Access::Everybody,
            };
            self.shared.access.set(access);
        }
        Ok(())
    }

    /// Holders of this key, and a number by which nothing that was sent before can be sent again: from a count
    /// that the store has kept before the number is used, and from random numbers, where there are any. If both
    /// fail, nobody is let in.
    async fn holders(&mut self, key: Key) -> Access {
        let count = self.store.count();
        let count = self.shared.liveness.while_waiting(SafetyTask::Supervisor, count).await;
        self.store_damaged |= count.is_err();
        match (count, self.board.random) {
            (Err(_), None) => Access::Nobody,
            (count, random) => {
                let (count, random) = (count.unwrap_or(0), random.unwrap_or_default());
                Access::Holders { key, boot: key.boot(&self.board.uid, count, &random) }
            }
        }
    }
}
