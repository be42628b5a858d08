//! Names of closed sets, as users type them.

/// A name that is not in a closed set.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no {what} is called `{name}`: expected one of {known}")]
pub struct UnknownName {
    /// Kind of the thing named.
    pub what: &'static str,
    /// The name given.
    pub name: String,
    /// The names there are.
    pub known: String,
}

impl UnknownName {
    /// The element of `all` with this name.
    ///
    /// # Errors
    /// [`UnknownName`] where there is none.
    pub fn find<T: Copy>(
        what: &'static str,
        name: &str,
        all: impl IntoIterator<Item = T>,
        name_of: impl Fn(T) -> &'static str,
    ) -> Result<T, Self> {
        let all: Vec<T> = all.into_iter().collect();
        all.iter().copied().find(|&one| name_of(one) == name).ok_or_else(|| Self {
            what,
            name: name.to_owned(),
            known: all.iter().map(|&one| name_of(one)).collect::<Vec<_>>().join(", "),
        })
    }
}
