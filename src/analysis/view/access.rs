//! Who may use the server of a view: the token in its address, and the names of this machine.

/// Random bytes of a token.
const TOKEN_BYTES: usize = 16;

/// Secret part of the address of a view, in hexadecimal digits.
pub struct AccessToken(String);

impl AccessToken {
    /// Creates a token of 128 random bits of the operating system.
    ///
    /// # Errors
    /// If the operating system returns no random bytes.
    pub fn random() -> Result<AccessToken, String> {
        let mut bytes = [0; TOKEN_BYTES];
        getrandom::fill(&mut bytes).map_err(|e| format!("the operating system returns no random bytes: {e}"))?;
        Ok(AccessToken(format!("{:032x}", u128::from_be_bytes(bytes))))
    }

    pub fn text(&self) -> &str {
        &self.0
    }

    /// Returns whether a text is the token. The time does not depend on the position of the first difference.
    pub fn matches(&self, given: &str) -> bool {
        let differences = self.0.bytes().zip(given.bytes()).fold(0, |all, (a, b)| all | (a ^ b));
        given.len() == self.0.len() && std::hint::black_box(differences) == 0
    }
}

/// Returns whether the header `Host` names this machine, with any port: a forwarded port differs from the server's. A page
/// of another site whose name has been resolved to 127.0.0.1 sends the name of that site.
pub fn is_local_host(host: &str) -> bool {
    let (name, port) = host.rsplit_once(':').unwrap_or((host, "0"));
    let is_port = !port.is_empty() && port.bytes().all(|b| b.is_ascii_digit());
    is_port && (name == "127.0.0.1" || name.eq_ignore_ascii_case("localhost"))
}

/// Returns whether the header `Origin` of a request is that of the page that the server of this `Host` has sent.
pub fn is_own_origin(origin: &str, host: &str) -> bool {
    origin.strip_prefix("http://").is_some_and(|name| name.eq_ignore_ascii_case(host))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_are_random_and_only_the_whole_token_matches() {
        let [first, second] = [(); 2].map(|()| AccessToken::random().expect("random bytes"));
        assert_ne!(first.text(), second.text());
        assert_eq!(first.text().len(), 2 * TOKEN_BYTES);
        assert!(first.matches(first.text()));
        for wrong in ["", &first.text()[1..], second.text(), &format!("{}0", first.text())] {
            assert!(!first.matches(wrong), "{wrong}");
        }
    }

    #[test]
    fn only_names_of_this_machine_are_local() {
        for host in ["127.0.0.1:8000", "localhost:1", "LocalHost"] {
            assert!(is_local_host(host), "{host}");
        }
        for host in
            ["", "127.0.0.1:", "127.0.0.1:a", "example.org", "example.org:80", "localhost.example.org", "10.0.0.1"]
        {
            assert!(!is_local_host(host), "{host}");
        }
        assert!(is_own_origin("http://localhost:8000", "localhost:8000"));
        for origin in ["null", "http://example.org", "http://localhost:8001", "https://localhost:8000"] {
            assert!(!is_own_origin(origin, "localhost:8000"), "{origin}");
        }
    }
}
