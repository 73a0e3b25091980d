//! The names that types of the protocol have in JavaScript.

use ca_haptic::control::Given;
use serde_json::Value;
use std::collections::BTreeMap;

/// A type that a message may have, by its name in JSDoc.
pub(super) trait Js {
    /// Its name.
    fn js() -> String;

    /// Its name in a request. `None` stands there for what was left out or has another type, which is refused.
    fn sent() -> String {
        Self::js()
    }
}

macro_rules! names {
    ($($type:ty: $name:literal,)+) => {
        $(impl Js for $type {
            fn js() -> String {
                $name.into()
            }
        })+
    };
}

names! {
    bool: "boolean",
    u8: "number",
    u32: "number",
    u64: "number",
    i64: "number",
    f64: "number",
    String: "string",
    Value: "any",
    Given: "number|string",
}

impl<T: Js> Js for Vec<T> {
    fn js() -> String {
        format!("Array<{}>", T::js())
    }
}

impl<T: Js> Js for BTreeMap<String, T> {
    fn js() -> String {
        format!("Object<string, {}>", T::js())
    }
}

impl<T: Js> Js for Option<T> {
    fn js() -> String {
        format!("{}|null", T::js())
    }

    fn sent() -> String {
        T::js()
    }
}
