//! The transfer functions at hand: resolved once, kept while their file is broken.
//!
//! What is seen names functions or holds them ([`TransferSource`]). They are resolved here, on the window's thread, only when
//! that changes; the threads that draw get the result. A file that is edited by somebody ([`super::watch`]) comes in by
//! [`Functions::reload`]; if it cannot be used, the last good one stays.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::transfer::{Imported, TransferFunction, TransferSource};

/// Resolved functions, or why there are none.
pub type Resolved = Result<Arc<TransferFunction>, String>;

/// Remembers what a source resolves to.
#[derive(Clone, Debug, Default)]
pub struct Functions {
    last: Option<(TransferSource, Resolved)>,
    /// Named ones whose files have changed since they were first read.
    reloaded: BTreeMap<String, Arc<TransferFunction>>,
    notices: Vec<String>,
}

impl Functions {
    /// The functions of a source.
    pub fn of(&mut self, source: &TransferSource) -> Resolved {
        if let Some((of, resolved)) = &self.last
            && of == source
        {
            return resolved.clone();
        }
        let newer = match source {
            TransferSource::Named(name) => self.reloaded.get(name),
            TransferSource::Inline(_) => None,
        };
        let resolved = match newer {
            Some(function) => Ok(Arc::clone(function)),
            None => source.import(None, None).map_err(|e| e.to_string()).map(|imported| {
                self.notices.extend(imported.notices);
                Arc::new(imported.function)
            }),
        };
        self.last = Some((source.clone(), resolved.clone()));
        resolved
    }

    /// The functions of a source, if they are known already.
    pub fn known(&self, source: &TransferSource) -> Option<Arc<TransferFunction>> {
        self.last.as_ref().filter(|(of, _)| of == source).and_then(|(_, resolved)| resolved.clone().ok())
    }

    /// Takes what a named source's file says now; gives what is to be said if it is wrong. Then the last good one stays.
    ///
    /// # Errors
    /// A sentence with file, line and reason.
    pub fn reload(&mut self, name: &str, read: Result<Imported, String>) -> Result<(), String> {
        let imported = read.map_err(|reason| format!("{reason} (the last good one is kept)"))?;
        self.notices.extend(imported.notices);
        let function = Arc::new(imported.function);
        self.reloaded.insert(name.to_owned(), Arc::clone(&function));
        if let Some((TransferSource::Named(of), resolved)) = &mut self.last
            && of == name
        {
            *resolved = Ok(function);
        }
        Ok(())
    }

    /// What was mapped, approximated or left out since the last call.
    pub fn notices(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notices)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_broken_file_keeps_the_last_good_one() {
        let mut functions = Functions::default();
        let source = TransferSource::Named("pellucid".to_owned());
        let first = functions.of(&source).unwrap();
        assert!(Arc::ptr_eq(&first, &functions.of(&source).unwrap()), "resolved once");
        let other = TransferSource::Inline(Box::new(TransferFunction::uniform(0.5)));
        assert_eq!(*functions.of(&other).unwrap(), TransferFunction::uniform(0.5));
        let changed =
            Imported { function: TransferFunction::uniform(0.25), notices: vec!["computed: something".into()] };
        functions.of(&source).unwrap();
        functions.reload("pellucid", Ok(changed)).unwrap();
        assert_eq!(*functions.of(&source).unwrap(), TransferFunction::uniform(0.25));
        assert_eq!(functions.notices(), ["computed: something"]);
        let said = functions.reload("pellucid", Err("pellucid.toml:3:1: no".to_owned())).unwrap_err();
        assert!(said.contains(":3:1") && said.contains("last good"), "{said}");
        assert_eq!(*functions.of(&source).unwrap(), TransferFunction::uniform(0.25));
        assert!(functions.of(&TransferSource::Named("no such".to_owned())).is_err());
    }
}
