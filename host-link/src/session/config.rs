//! The robot's configuration, read and written.

use shared_proto::{Answer, Command, Config, ConfigOrigin, Refusal};

use super::{Session, wrong_answer};
use crate::error::{Error, Result};
use crate::validate::{valid_config, with_plain_name};

impl Session {
    /// The configuration in use.
    pub async fn read_config(&mut self) -> Result<Config> {
        match self.request(Command::ReadConfig).await? {
            Answer::Config(config) => valid_config(config),
            other => Err(wrong_answer("read the configuration", other)),
        }
    }

    /// Uses another configuration, reads it back and compares. In its name a question mark replaces each control character.
    pub async fn write_config(&mut self, config: &Config) -> Result<()> {
        let config = &with_plain_name(config.clone());
        config.validate().map_err(|error| Error::Refused {
            request: "use the configuration",
            refusal: Refusal::Config(error),
        })?;
        self.request(Command::WriteConfig(config.clone())).await?;
        if self.read_config().await? != *config {
            return Err(Error::ReadBackDiffers);
        }
        self.written = Some(config.clone());
        Ok(())
    }

    /// Makes the configuration in use survive power-off. The robot reads back what it wrote.
    ///
    /// What this session has written must still be in use afterwards, and be what is saved: on its way a line may have held
    /// back what another session wrote before.
    pub async fn save_config(&mut self) -> Result<()> {
        self.request(Command::SaveConfig).await?;
        if self.written.is_none() {
            return Ok(());
        }
        let in_use = self.read_config().await?;
        if self.written != Some(in_use) || self.identify().await?.unsaved {
            return Err(Error::ReadBackDiffers);
        }
        Ok(())
    }

    /// Goes back to an earlier configuration, and returns it.
    pub async fn restore_config(&mut self, origin: ConfigOrigin) -> Result<Config> {
        self.written = None;
        match self.request(Command::RestoreConfig(origin)).await? {
            Answer::Config(config) => valid_config(config),
            other => Err(wrong_answer("restore the configuration", other)),
        }
    }
}
