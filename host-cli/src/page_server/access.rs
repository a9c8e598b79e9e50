//! Who may ask: only this machine's own pages, or whoever has the key in the link.
//!
//! A web page of somebody else's, open in the same browser, can send requests to 127.0.0.1, under a name of its own if it
//! controls a name server (DNS rebinding). So every request must name this server as its host and, if it names an
//! origin, as its origin. Where other machines may ask, a key of 128 random bits in the link is needed as well.

use std::net::SocketAddr;

use subtle::ConstantTimeEq;

use crate::hex::hex;

/// Who may ask.
#[derive(Clone, Debug)]
pub struct Access {
    /// The hosts that a request may name; any, if the server is not on this machine alone.
    hosts: Option<Vec<String>>,
    /// What the link must have.
    key: Option<String>,
}

/// Why a request is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// It names another host.
    Host,
    /// It comes from another page.
    Origin,
    /// It has no key, or a wrong one.
    Key,
}

impl Access {
    /// Of a server at this address. Beyond this machine a key is drawn.
    pub fn at(address: SocketAddr) -> Result<Self, String> {
        if address.ip().is_loopback() {
            let port = address.port();
            let hosts = ["127.0.0.1", "localhost", "[::1]"].map(|host| format!("{host}:{port}"));
            return Ok(Self { hosts: Some(hosts.into()), key: None });
        }
        let mut bytes = [0; 16];
        getrandom::fill(&mut bytes)
            .map_err(|error| format!("the system has no random numbers: {error}"))?;
        Ok(Self { hosts: None, key: Some(hex(&bytes)) })
    }

    /// What stands behind the address in the link.
    pub fn query(&self) -> String {
        self.key.as_ref().map_or_else(String::new, |key| format!("?key={key}"))
    }

    /// Whether a request with these headers may be answered. `key` is what its link or header has.
    pub fn check(
        &self,
        host: Option<&str>,
        origin: Option<&str>,
        key: Option<&str>,
    ) -> Result<(), Refused> {
        let host = host.ok_or(Refused::Host)?;
        if let Some(hosts) = &self.hosts
            && !hosts.iter().any(|own| own.eq_ignore_ascii_case(host))
        {
            return Err(Refused::Host);
        }
        if origin.is_some_and(|origin| !origin.eq_ignore_ascii_case(&format!("http://{host}"))) {
            return Err(Refused::Origin);
        }
        match &self.key {
            Some(own) if !bool::from(own.as_bytes().ct_eq(key.unwrap_or_default().as_bytes())) => {
                Err(Refused::Key)
            }
            _ => Ok(()),
        }
    }
}

impl Refused {
    /// In words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Host => "this page answers at its own address only",
            Self::Origin => "this page answers to itself only, not to other pages",
            Self::Key => "the key is missing or wrong: open the link that `beeline serve` printed",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn local() -> Access {
        Access::at("127.0.0.1:7780".parse().unwrap()).unwrap()
    }

    #[test]
    fn only_the_page_itself_is_answered_on_this_machine() {
        let access = local();
        let own = Some("127.0.0.1:7780");
        assert_eq!(access.check(own, None, None), Ok(()));
        assert_eq!(
            access.check(Some("LOCALHOST:7780"), Some("http://localhost:7780"), None),
            Ok(())
        );
        for host in
            [None, Some("evil.example:7780"), Some("127.0.0.1"), Some("127.0.0.1:80"), Some("")]
        {
            assert_eq!(access.check(host, None, None), Err(Refused::Host), "{host:?}");
        }
        for origin in
            ["http://evil.example", "null", "https://127.0.0.1:7780", "http://localhost:7780", ""]
        {
            assert_eq!(access.check(own, Some(origin), None), Err(Refused::Origin), "{origin}");
        }
        assert_eq!(access.query(), "");
    }

    #[test]
    fn beyond_this_machine_the_key_of_the_link_is_needed() {
        let at = || Access::at("0.0.0.0:7780".parse().unwrap()).unwrap();
        let access = at();
        let query = access.query();
        let key = query.strip_prefix("?key=").unwrap();
        assert_eq!(key.len(), 32);
        assert_ne!(query, at().query());
        let host = Some("robot.lan:7780");
        assert_eq!(access.check(host, None, Some(key)), Ok(()));
        for wrong in [None, Some(""), Some(&key[..31]), Some("0123456789abcdef0123456789abcdef")] {
            assert_eq!(access.check(host, None, wrong), Err(Refused::Key), "{wrong:?}");
        }
        let stranger = access.check(host, Some("http://evil.example"), Some(key));
        assert_eq!(stranger, Err(Refused::Origin));
    }
}
