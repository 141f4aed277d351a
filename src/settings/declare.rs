//! The one declaration of a setting, and what is made of it.

use super::SettingsError;
use crate::math::spelling::edit_distance;
use crate::transfer;

/// What a setting may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// A whole number, both ends included.
    Integer(i64, i64),
    /// A finite number, both ends included.
    Real(f64, f64),
    /// One of these names.
    Choice(&'static [&'static str]),
    /// `true` or `false`.
    Switch,
    /// Text, checked where it is used.
    Text,
    /// A colour, `#rrggbb` in sRGB; or also `none`.
    Color {
        /// Whether it may be none.
        or_none: bool,
    },
}

/// The first of several names that is not the default.
fn other_than(default: &toml::Value, names: &[&str]) -> String {
    names.iter().find(|name| default.as_str() != Some(name)).map_or_else(String::new, |name| (*name).to_owned())
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Range::Integer(least, most) => write!(f, "a whole number from {least} to {most}"),
            Range::Real(least, most) => write!(f, "a number from {least} to {most}"),
            Range::Choice(names) => write!(f, "one of {}", names.join(", ")),
            Range::Switch => write!(f, "true or false"),
            Range::Text => write!(f, "text"),
            Range::Color { or_none: true } => write!(f, "none or the form #rrggbb"),
            Range::Color { or_none: false } => write!(f, "the form #rrggbb"),
        }
    }
}

/// Name, range, default and help of one setting.
#[derive(Clone, Debug, PartialEq)]
pub struct Declaration {
    /// Dotted path, as in `capture.bucketed_k_buffer.k`.
    pub path: String,
    /// What it may be.
    pub range: Range,
    /// Its default, as TOML.
    pub default: toml::Value,
    /// What it does, in a sentence or two.
    pub help: String,
}

impl Declaration {
    /// An allowed value that is not the default, as text: for whatever has to try a change of every setting.
    pub fn another(&self) -> String {
        match (self.range, &self.default) {
            (Range::Integer(_, most), default) => {
                let usual = default.as_integer().unwrap_or(most);
                (if usual < most { usual + 1 } else { usual - 1 }).to_string()
            }
            (Range::Real(least, most), default) => {
                // Nothing round: digits are what gets lost.
                let at = |share: f64| ((least + share * (most - least)) * 1e5).round() / 1e5;
                let first = at(0.371_91);
                (if default.as_float() == Some(first) { at(0.619_37) } else { first }).to_string()
            }
            (Range::Choice(names), default) => other_than(default, names),
            (Range::Switch, default) => (default.as_bool() != Some(true)).to_string(),
            (Range::Color { .. }, default) => other_than(default, &["#1a2b3c", "#3c2b1a"]),
            // Text is the name of transfer functions.
            (Range::Text, default) => other_than(default, &transfer::names()),
        }
    }

    /// Reads the setting's value from text.
    pub(super) fn parse(&self, text: &str) -> Result<toml::Value, SettingsError> {
        let refused = || self.refusal(text);
        let value = match self.range {
            Range::Integer(..) => toml::Value::Integer(text.trim().parse().map_err(|_| refused())?),
            Range::Real(..) => toml::Value::Float(text.trim().parse().map_err(|_| refused())?),
            Range::Switch => toml::Value::Boolean(text.trim().parse().map_err(|_| refused())?),
            Range::Choice(_) | Range::Text | Range::Color { .. } => toml::Value::String(text.to_owned()),
        };
        self.check(value)
    }

    /// Checks type and range; a whole number is accepted where a real one is meant.
    pub(super) fn check(&self, value: toml::Value) -> Result<toml::Value, SettingsError> {
        use toml::Value;
        let ok = match (self.range, &value) {
            (Range::Integer(least, most), Value::Integer(n)) => (least..=most).contains(n),
            (Range::Real(least, most), Value::Float(x)) => (least..=most).contains(x),
            (Range::Real(..), &Value::Integer(n)) => return self.check(Value::Float(n as f64)),
            (Range::Choice(names), Value::String(s)) => names.contains(&s.as_str()),
            (Range::Switch, Value::Boolean(_)) => true,
            (Range::Text, Value::String(_) | Value::Table(_)) => true,
            (Range::Color { or_none }, Value::String(s)) => transfer::hex(s).is_some() || or_none && s == "none",
            _ => false,
        };
        if ok { Ok(value) } else { Err(self.refusal(&value.to_string())) }
    }

    fn refusal(&self, value: &str) -> SettingsError {
        SettingsError::Value { path: self.path.clone(), value: value.to_owned(), expected: self.range.to_string() }
    }
}

/// The declaration with this path, or an error that names the closest one.
pub(super) fn find(path: &str, declarations: &[Declaration]) -> Result<Declaration, SettingsError> {
    declarations.iter().find(|d| d.path == path).cloned().ok_or_else(|| SettingsError::Unknown {
        path: path.to_owned(),
        nearest: declarations
            .iter()
            .map(|d| (edit_distance(path, &d.path), &d.path))
            .min()
            .filter(|(distance, _)| *distance <= 12)
            .map(|(_, p)| p.clone()),
    })
}

/// What is done with each value of a table: gets its path and the value.
type Visit<'a> = dyn FnMut(&str, &toml::Value) -> Result<(), SettingsError> + 'a;

/// Calls `visit` for every value of `table` that is a setting, with its path; an unknown path is an error.
pub(super) fn for_each_leaf(
    table: &toml::Table,
    declarations: &[Declaration],
    visit: &mut Visit<'_>,
) -> Result<(), SettingsError> {
    fn walk(
        prefix: &str,
        table: &toml::Table,
        declarations: &[Declaration],
        visit: &mut Visit<'_>,
    ) -> Result<(), SettingsError> {
        for (key, value) in table {
            let path = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
            let inner = format!("{path}.");
            match value {
                toml::Value::Table(t) if declarations.iter().any(|d| d.path.starts_with(&inner)) => {
                    walk(&path, t, declarations, visit)?;
                }
                _ => {
                    find(&path, declarations)?;
                    visit(&path, value)?;
                }
            }
        }
        Ok(())
    }
    walk("", table, declarations, visit)
}

/// Declares an enumeration whose variants have names.
macro_rules! choice {
    ($(#[$outer:meta])* pub enum $Name:ident { $($(#[doc = $doc:literal])+ $(#[$default:ident])? $Variant:ident = $name:literal,)+ }) => {
        $(#[$outer])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
        pub enum $Name { $($(#[doc = $doc])+ $(#[$default])? #[serde(rename = $name)] $Variant,)+ }

        impl $Name {
            /// The names, in order.
            pub const NAMES: &'static [&'static str] = &[$($name),+];
            /// The variants, in order.
            pub const ALL: &'static [$Name] = &[$($Name::$Variant),+];

            /// The name of this variant.
            pub fn name(self) -> &'static str {
                match self { $($Name::$Variant => $name),+ }
            }
        }
    };
}

/// Declares a struct of settings: `name: type = default, range;` for a value, `group name: type;` for a nested struct.
macro_rules! settings {
    ($(#[doc = $outer:literal])+ pub struct $Name:ident { $($body:tt)* }) => {
        $crate::settings::declare::settings!(@munch [$(#[doc = $outer])+] $Name {} {} {} $($body)*);
    };
    (@munch $outer:tt $Name:ident {$($fields:tt)*} {$($defaults:tt)*} {$($declares:tt)*}
        $(#[doc = $doc:literal])+ pub group $field:ident: $ty:ty; $($rest:tt)*) => {
        $crate::settings::declare::settings!(@munch $outer $Name
            {$($fields)* $(#[doc = $doc])+ pub $field: $ty,}
            {$($defaults)* $field: Default::default(),}
            {$($declares)* (group $field $ty)}
            $($rest)*);
    };
    (@munch $outer:tt $Name:ident {$($fields:tt)*} {$($defaults:tt)*} {$($declares:tt)*}
        $(#[doc = $doc:literal])+ pub $field:ident: $ty:ty = $default:expr, $range:expr; $($rest:tt)*) => {
        $crate::settings::declare::settings!(@munch $outer $Name
            {$($fields)* $(#[doc = $doc])+ pub $field: $ty,}
            {$($defaults)* $field: $default,}
            {$($declares)* (leaf $field ($range) ($default) ($($doc)+))}
            $($rest)*);
    };
    (@munch [$($outer:tt)*] $Name:ident {$($fields:tt)*} {$($defaults:tt)*} {$($declares:tt)*}) => {
        $($outer)*
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct $Name { $($fields)* }

        impl Default for $Name {
            fn default() -> $Name { $Name { $($defaults)* } }
        }

        impl $Name {
            pub(in crate::settings) fn declare(prefix: &str, all: &mut Vec<Declaration>) {
                $($crate::settings::declare::settings!(@declare prefix all $declares);)*
            }
        }
    };
    (@declare $prefix:ident $all:ident (group $field:ident $ty:ty)) => {
        <$ty>::declare(&format!("{}{}.", $prefix, stringify!($field)), $all);
    };
    (@declare $prefix:ident $all:ident (leaf $field:ident ($range:expr) ($default:expr) ($($doc:literal)+))) => {
        $all.push(Declaration {
            path: format!("{}{}", $prefix, stringify!($field)),
            range: $range,
            default: toml::Value::try_from($default).expect("a default has a TOML form"),
            help: [$($doc.trim()),+].join(" "),
        });
    };
}

pub(super) use {choice, settings};
