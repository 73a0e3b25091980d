//! Macros that declare messages and records with their documentation.

/// A field of a message: its name, its type in JavaScript, and its description.
pub type Fields = Vec<(&'static str, String, String)>;

/// One kind of message, or one record, for the generated pages.
#[derive(Clone, Debug, PartialEq)]
pub struct Kind {
    /// `type` on the wire; the name of a record
    pub name: &'static str,
    /// what it means
    pub doc: String,
    /// its fields, without `type`
    pub fields: Fields,
}

/// Joins the lines of a doc comment.
pub(super) fn joined(lines: &[&str]) -> String {
    lines.iter().map(|l| l.trim()).collect::<Vec<_>>().join(" ")
}

/// An enum of messages. `$how` are the serde attributes of each field, `$js` the method that names its type in JavaScript.
/// A field may have further serde attributes in brackets.
macro_rules! messages {
    (
        $(#[$about:meta])*
        $name:ident, $how:tt, $js:ident;
        $(
            $(#[doc = $doc:literal])+
            $wire:literal $variant:ident $({
                $($(#[doc = $said:literal])+ $([$more:tt])? $field:ident: $type:ty,)+
            })?
        )+
    ) => {
        $(#[$about])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(tag = "type")]
        pub enum $name {
            $(
                $(#[doc = $doc])+
                #[serde(rename = $wire)]
                $variant $({
                    $($(#[doc = $said])+ #[serde $how] $(#[serde $more])? $field: $type,)+
                })?,
            )+
        }

        impl $name {
            /// All kinds of it, for the generated pages.
            pub fn kinds() -> Vec<$crate::protocol::Kind> {
                vec![$($crate::protocol::Kind {
                    name: $wire,
                    doc: $crate::protocol::define::joined(&[$($doc),+]),
                    fields: vec![$($((
                        stringify!($field),
                        <$type as $crate::protocol::js::Js>::$js(),
                        $crate::protocol::define::joined(&[$($said),+]),
                    )),+)?],
                }),+]
            }
        }
    };
}

/// A structure inside messages.
macro_rules! record {
    (
        $(#[doc = $doc:literal])+
        $name:ident { $($(#[doc = $said:literal])+ $field:ident: $type:ty,)+ }
    ) => {
        $(#[doc = $doc])+
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        pub struct $name {
            $($(#[doc = $said])+ pub $field: $type,)+
        }

        impl $crate::protocol::js::Js for $name {
            fn js() -> String {
                stringify!($name).into()
            }
        }

        impl $name {
            /// Its fields, for the generated pages.
            pub fn kind() -> $crate::protocol::Kind {
                $crate::protocol::Kind {
                    name: stringify!($name),
                    doc: $crate::protocol::define::joined(&[$($doc),+]),
                    fields: vec![$((
                        stringify!($field),
                        <$type as $crate::protocol::js::Js>::js(),
                        $crate::protocol::define::joined(&[$($said),+]),
                    )),+],
                }
            }
        }
    };
}

pub(super) use {messages, record};
