//! Who may ask: requests of this page only, and headers that keep the page to itself.

use std::net::SocketAddr;
use std::sync::Arc;

use axum::extract::{Request, State};
use axum::http::header::{
    AUTHORIZATION, CACHE_CONTROL, CONTENT_SECURITY_POLICY, COOKIE, HOST, LOCATION, ORIGIN, REFERRER_POLICY,
    SET_COOKIE, X_CONTENT_TYPE_OPTIONS, X_FRAME_OPTIONS,
};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, Uri};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::Shared;
use crate::api::Problem;
use crate::refused::Refused;

/// Nothing from elsewhere, nothing inline, no frames.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; \
    font-src 'self'; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
/// What the name of the cookie with the token begins with; the port follows, since the servers of a machine
/// share its cookies.
const COOKIE_NAME: &str = "hysteron-";

/// Who may ask.
pub(crate) struct Access {
    port: u16,
    /// Needed in every request where others than this machine can ask.
    pub(super) token: Option<String>,
}

impl Access {
    /// To a server that listens on an address.
    ///
    /// # Errors
    /// If the system has no random numbers.
    pub(super) fn to(address: SocketAddr) -> std::io::Result<Self> {
        let token = if address.ip().is_loopback() {
            None
        } else {
            let mut bytes = [0u8; 16];
            getrandom::fill(&mut bytes).map_err(|e| std::io::Error::other(e.to_string()))?;
            Some(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
        };
        Ok(Self { port: address.port(), token })
    }

    /// Whether a `Host` is one that leads here by itself: an address, or `localhost`. A name of the network
    /// can be made to lead here by whoever owns it.
    fn is_own(&self, host: &str) -> bool {
        let Ok(host) = host.parse::<axum::http::uri::Authority>() else { return false };
        let name = host.host().trim_start_matches('[').trim_end_matches(']');
        let is_here = match name.parse::<std::net::IpAddr>() {
            Ok(address) => address.is_loopback() || self.token.is_some(),
            Err(_) => name.eq_ignore_ascii_case("localhost"),
        };
        is_here && host.port_u16().unwrap_or(80) == self.port && !host.as_str().contains('@')
    }

    /// Why a request is refused, if it is. A foreign page's image or script comes without `Origin`; browsers
    /// say where it comes from otherwise. A link to the page itself may come from anywhere.
    fn refuses(&self, headers: &HeaderMap, uri: &Uri) -> Option<&'static str> {
        let mut hosts = headers.get_all(HOST).iter();
        let host = hosts.next().and_then(|host| host.to_str().ok());
        let Some(host) = host.filter(|host| self.is_own(host)) else {
            return Some("this server answers to its own address only");
        };
        if hosts.next().is_some() {
            return Some("a request names one host");
        }
        let own = format!("http://{host}");
        let is =
            |name: &str, values: &[&str]| headers.get(name).is_none_or(|v| values.iter().any(|x| v == x));
        let is_link = uri.path() == "/" && is("sec-fetch-mode", &["navigate"]);
        let foreign = headers.get_all(ORIGIN).iter().any(|origin| origin.as_bytes() != own.as_bytes())
            || !(is_link || is("sec-fetch-site", &["same-origin", "none"]));
        foreign.then_some("this server answers to its own page only")
    }

    /// Whether the token is given where one is needed.
    fn knows(&self, headers: &HeaderMap, uri: &Uri) -> bool {
        let Some(token) = &self.token else { return true };
        let bearer = headers.get(AUTHORIZATION).and_then(|value| value.to_str().ok());
        let bearer = bearer.and_then(|value| value.strip_prefix("Bearer "));
        let cookies = headers.get_all(COOKIE).iter().filter_map(|value| value.to_str().ok());
        let mut cookies = cookies.flat_map(|cookies| cookies.split(';'));
        let own = format!("{COOKIE_NAME}{}=", self.port);
        bearer.is_some_and(|given| is_same(given, token))
            || cookies
                .any(|cookie| cookie.trim().strip_prefix(&own).is_some_and(|given| is_same(given, token)))
            || in_query(uri).is_some_and(|given| is_same(given, token))
    }
}

fn in_query(uri: &Uri) -> Option<&str> {
    uri.query()?.split('&').find_map(|pair| pair.strip_prefix("token="))
}

/// Compares in a time that does not tell how much agrees.
fn is_same(given: &str, token: &str) -> bool {
    let differs = given.bytes().zip(token.bytes()).fold(0, |differs, (a, b)| differs | (a ^ b));
    given.len() == token.len() && differs == 0
}

/// Refuses requests of others; gives every answer the headers of the page.
pub(super) async fn guard(State(shared): State<Arc<Shared>>, request: Request, next: Next) -> Response {
    let access = &shared.access;
    let refused = access.refuses(request.headers(), request.uri());
    let response = if let Some(why) = refused {
        Refused::new(StatusCode::FORBIDDEN, Problem::new(why, None)).into_response()
    } else if !access.knows(request.headers(), request.uri()) {
        let why = "the token of this server is missing";
        let remedy = "Open the address that hysteron app printed on its terminal.";
        let problem = Problem { remedy: Some(remedy.to_owned()), ..Problem::new(why, None) };
        Refused::new(StatusCode::FORBIDDEN, problem).into_response()
    } else if let Some(token) = in_query(request.uri()).filter(|_| access.token.is_some()) {
        remembered(token, access.port)
    } else {
        next.run(request).await
    };
    with_headers(response)
}

/// Keeps the token in a cookie, so that it does not stay in the address.
fn remembered(token: &str, port: u16) -> Response {
    let cookie = format!("{COOKIE_NAME}{port}={token}; Path=/; HttpOnly; SameSite=Strict");
    let mut response = StatusCode::SEE_OTHER.into_response();
    let headers = response.headers_mut();
    headers.insert(LOCATION, HeaderValue::from_static("/"));
    if let Ok(cookie) = HeaderValue::from_str(&cookie) {
        headers.insert(SET_COOKIE, cookie);
    }
    response
}

fn with_headers(mut response: Response) -> Response {
    let headers = response.headers_mut();
    let fixed = [
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (X_FRAME_OPTIONS, "DENY"),
        (REFERRER_POLICY, "no-referrer"),
        (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    ];
    for (name, value) in fixed {
        headers.insert(name, HeaderValue::from_static(value));
    }
    // A report brings its own policy.
    headers.entry(CONTENT_SECURITY_POLICY).or_insert(HeaderValue::from_static(POLICY));
    headers.entry(CACHE_CONTROL).or_insert(HeaderValue::from_static("no-store"));
    response
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;

    fn headers(host: &str, origin: Option<&str>) -> HeaderMap {
        let mut headers = HeaderMap::new();
        headers.insert(HOST, host.parse().unwrap());
        if let Some(origin) = origin {
            headers.insert(ORIGIN, origin.parse().unwrap());
        }
        headers
    }

    #[test]
    fn only_its_own_address_and_page_are_answered() {
        let access = Access::to("127.0.0.1:80".parse().unwrap()).unwrap();
        let access = Access { port: 4711, ..access };
        let page: Uri = "/".parse().unwrap();
        for host in ["127.0.0.1:4711", "localhost:4711", "LOCALHOST:4711", "[::1]:4711"] {
            assert_eq!(access.refuses(&headers(host, None), &page), None, "{host}");
            assert_eq!(
                access.refuses(&headers(host, Some(&format!("http://{host}"))), &page),
                None,
                "{host}"
            );
        }
        for host in [
            "127.0.0.1",
            "127.0.0.1:4712",
            "evil.example:4711",
            "127.0.0.1.evil.example:4711",
            "10.0.0.1:4711",
            "a@127.0.0.1:4711",
            "",
            "localhost.evil.example:4711",
        ] {
            assert!(access.refuses(&headers(host, None), &page).is_some(), "{host}");
        }
        for origin in ["http://evil.example", "null", "https://127.0.0.1:4711", "http://127.0.0.1:1"] {
            assert!(access.refuses(&headers("127.0.0.1:4711", Some(origin)), &page).is_some(), "{origin}");
        }
        assert!(access.refuses(&HeaderMap::new(), &page).is_some());
        let record: Uri = "/api/v1/records".parse().unwrap();
        for (site, mode, uri, is_refused) in [
            ("cross-site", "no-cors", &record, true),
            ("same-site", "cors", &record, true),
            ("cross-site", "navigate", &record, true),
            ("cross-site", "navigate", &page, false),
            ("none", "navigate", &record, false),
            ("same-origin", "cors", &record, false),
        ] {
            let mut headers = headers("127.0.0.1:4711", None);
            headers.insert("sec-fetch-site", site.parse().unwrap());
            headers.insert("sec-fetch-mode", mode.parse().unwrap());
            assert_eq!(access.refuses(&headers, uri).is_some(), is_refused, "{site} {mode} {uri}");
        }
    }

    #[test]
    fn another_address_needs_the_token() {
        let access = Access::to("0.0.0.0:4711".parse().unwrap()).unwrap();
        let token = access.token.clone().unwrap();
        assert_eq!(token.len(), 32);
        let uri: Uri = "/api/v1/records".parse().unwrap();
        let mut headers = headers("10.0.0.1:4711", None);
        assert_eq!(access.refuses(&headers, &uri), None);
        assert!(!access.knows(&headers, &uri));
        assert!(access.knows(&headers, &format!("/?token={token}").parse().unwrap()));
        headers.insert(COOKIE, format!("a=b; hysteron-1=0; hysteron-4711={token}").parse().unwrap());
        assert!(access.knows(&headers, &uri));
        headers.insert(COOKIE, "hysteron-4711=0".parse().unwrap());
        assert!(!access.knows(&headers, &uri));
        headers.insert(AUTHORIZATION, format!("Bearer {token}").parse().unwrap());
        assert!(access.knows(&headers, &uri));
    }
}
