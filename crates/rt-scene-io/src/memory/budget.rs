//! Memory budget of loading, checked before memory is allocated.
//!
//! ```text
//!   held + predicted ≤ budget ?   yes ──> a reservation, which counts until it is dropped or kept
//!                                 no  ──> LoadErrorKind::Memory: predicted sum, budget, largest part
//! ```

use std::collections::BTreeMap;
use std::fmt::Display;
use std::sync::{Arc, Mutex, PoisonError};

use crate::{LoadErrorKind, MemoryError};

/// Maximum number of bytes for loading: loaded data and intermediate data. Unlimited by default.
///
/// Clones share one account. Loaders estimate the memory of a file from its size, header and counts, and reserve it before they
/// read on. The estimates are upper bounds.
#[derive(Clone, Debug, Default)]
pub struct MemoryBudget(Option<Arc<Account>>);

#[derive(Debug)]
struct Account {
    limit: u64,
    entries: Mutex<AccountEntries>,
}

/// Reservations by id.
#[derive(Debug, Default)]
struct AccountEntries {
    held: u64,
    next: u64,
    list: BTreeMap<u64, (String, u64)>,
}

/// Bytes that are set aside until this is dropped.
#[derive(Debug)]
#[must_use = "what is dropped at once reserves nothing"]
pub(crate) struct Reservation {
    account: Option<(Arc<Account>, u64)>,
}

impl MemoryBudget {
    /// A budget of this number of bytes.
    pub fn of(bytes: u64) -> Self {
        Self(Some(Arc::new(Account { limit: bytes, entries: Mutex::default() })))
    }

    /// The limit in bytes; `None` if there is none.
    pub fn limit(&self) -> Option<u64> {
        self.0.as_ref().map(|account| account.limit)
    }

    /// Bytes that are reserved now, by loaded data and by files being read.
    pub fn held(&self) -> u64 {
        self.0.as_ref().map_or(0, |account| account.entries().held)
    }

    /// Reserves bytes. `what` completes the sentence "most of it is for ...".
    pub(crate) fn reserve(&self, what: impl Display, bytes: u64) -> Result<Reservation, LoadErrorKind> {
        let Some(account) = &self.0 else { return Ok(Reservation { account: None }) };
        let mut entries = account.entries();
        let predicted = entries.held.saturating_add(bytes);
        if predicted > account.limit {
            return Err(entries.exceeded(&what, bytes, account.limit));
        }
        let number = entries.next;
        entries.next += 1;
        entries.held = predicted;
        entries.list.insert(number, (what.to_string(), bytes));
        drop(entries);
        Ok(Reservation { account: Some((Arc::clone(account), number)) })
    }

    /// Checks that this number of bytes is left, without a reservation.
    pub(crate) fn check(&self, what: impl Display, bytes: u64) -> Result<(), LoadErrorKind> {
        self.reserve(what, bytes).map(drop)
    }

    /// Sets bytes aside for as long as the budget lasts.
    pub(crate) fn keep(&self, what: impl Display, bytes: u64) -> Result<(), LoadErrorKind> {
        // The entry stays in the account.
        self.reserve(what, bytes).map(|mut reservation| reservation.account = None)
    }
}

impl Account {
    fn entries(&self) -> std::sync::MutexGuard<'_, AccountEntries> {
        self.entries.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl AccountEntries {
    fn exceeded(&self, what: &impl Display, bytes: u64, budget: u64) -> LoadErrorKind {
        let largest = self.list.values().max_by_key(|(_, bytes)| *bytes).filter(|(_, most)| *most > bytes);
        let (largest, most) = largest.cloned().unwrap_or_else(|| (what.to_string(), bytes));
        MemoryError { predicted: self.held.saturating_add(bytes), budget, largest, most }.into()
    }
}

impl Drop for Reservation {
    fn drop(&mut self) {
        let Some((account, number)) = &self.account else { return };
        let mut entries = account.entries();
        if let Some((_, bytes)) = entries.list.remove(number) {
            entries.held -= bytes;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_limit_anything_is_granted() {
        let budget = MemoryBudget::default();
        assert!(budget.keep("all", u64::MAX).is_ok() && budget.check("more", u64::MAX).is_ok());
        assert_eq!((budget.limit(), budget.held()), (None, 0));
    }

    #[test]
    fn reservations_count_until_they_are_dropped_and_what_is_kept_counts_for_good() {
        let budget = MemoryBudget::of(100);
        let first = budget.reserve("a", 60).expect("60 of 100");
        assert_eq!(budget.held(), 60);
        assert!(budget.check("b", 40).is_ok() && budget.check("b", 41).is_err());
        drop(first);
        // Clones share the account.
        budget.clone().keep("c", 90).expect("90 of 100");
        assert_eq!(budget.held(), 90);
        assert!(budget.check("d", 11).is_err());
    }

    #[test]
    fn a_refusal_says_what_needs_most() {
        let budget = MemoryBudget::of(10 << 20);
        budget.keep("the texture a.png", 6 << 20).expect("6 of 10 MiB");
        let refused = |bytes| budget.check("the model b.obj", bytes).expect_err("too much").to_string();
        let small = refused(5 << 20);
        assert_eq!(
            small,
            "needs 11.0 MiB of memory, more than the limit of 10.0 MiB (raise --memory); most of it, 6.0 MiB, is \
             for the texture a.png"
        );
        assert!(refused(7 << 20).ends_with("most of it, 7.0 MiB, is for the model b.obj"));
        assert!(refused(u64::MAX).contains("needs 16.0 EiB"), "no overflow");
    }
}
