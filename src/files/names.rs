//! Lists of numbers by name, and JSON with unique names.

use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use serde_json::Value;
use std::collections::HashMap;
use std::fmt;
use std::marker::PhantomData;

use crate::Error;

/// Values by name, in the order of the scene or of the file; names are unique.
#[derive(Clone, Debug)]
pub(super) struct Named<T>(pub(super) Vec<(String, T)>);

impl<T> Named<T> {
    pub(super) fn new<'a>(names: impl Iterator<Item = &'a str>, values: impl Iterator<Item = T>) -> Self {
        Named(names.map(str::to_string).zip(values).collect())
    }

    /// The values in the order of these names.
    ///
    /// # Errors
    /// A missing name, or a name that the system does not have.
    pub(super) fn in_order<'a>(
        self,
        kind: &'static str,
        part: &str,
        names: impl Iterator<Item = &'a str>,
    ) -> Result<Vec<T>, Error> {
        let wrong = |name: &str, problem: &str| Error::File {
            kind,
            place: format!("`{part}`"),
            problem: format!("{problem} `{name}`"),
        };
        let (known, mut values): (Vec<String>, Vec<Option<T>>) =
            self.0.into_iter().map(|(name, value)| (name, Some(value))).unzip();
        let places: HashMap<&str, usize> = known.iter().map(String::as_str).zip(0..).collect();
        let mut in_order = Vec::new();
        for name in names {
            let value = places.get(name).and_then(|&at| values[at].take());
            in_order.push(value.ok_or_else(|| wrong(name, "there is no value for"))?);
        }
        match values.iter().position(Option::is_some) {
            Some(at) => Err(wrong(&known[at], "the system has nothing called")),
            None => Ok(in_order),
        }
    }
}

impl<T: Serialize> Serialize for Named<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        self.0.iter().try_for_each(|(name, value)| map.serialize_entry(name, value))?;
        map.end()
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Named<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor<T>(PhantomData<T>);

        impl<'de, T: Deserialize<'de>> de::Visitor<'de> for Visitor<T> {
            type Value = Named<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("values by their names")
            }

            fn visit_map<A: de::MapAccess<'de>>(self, mut map: A) -> Result<Named<T>, A::Error> {
                let mut all: Vec<(String, T)> = Vec::new();
                let mut known = std::collections::HashSet::new();
                while let Some((name, value)) = map.next_entry::<String, T>()? {
                    if !known.insert(name.clone()) {
                        return Err(de::Error::custom(format!("`{name}` occurs twice here")));
                    }
                    all.push((name, value));
                }
                Ok(Named(all))
            }
        }

        deserializer.deserialize_map(Visitor(PhantomData))
    }
}

/// Any JSON whose objects have unique names.
pub(super) struct Unique(pub(super) Value);

impl<'de> Deserialize<'de> for Unique {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;

        impl<'de> de::Visitor<'de> for Visitor {
            type Value = Value;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("JSON")
            }

            fn visit_unit<E>(self) -> Result<Value, E> {
                Ok(Value::Null)
            }

            fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
                Ok(value.into())
            }

            fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
                Ok(value.into())
            }

            fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
                Ok(value.into())
            }

            fn visit_f64<E>(self, value: f64) -> Result<Value, E> {
                Ok(value.into())
            }

            fn visit_str<E>(self, value: &str) -> Result<Value, E> {
                Ok(value.into())
            }

            fn visit_seq<A: de::SeqAccess<'de>>(self, mut list: A) -> Result<Value, A::Error> {
                let mut all = Vec::new();
                while let Some(Unique(value)) = list.next_element()? {
                    all.push(value);
                }
                Ok(Value::Array(all))
            }

            fn visit_map<A: de::MapAccess<'de>>(self, map: A) -> Result<Value, A::Error> {
                let all = Named::<Unique>::deserialize(de::value::MapAccessDeserializer::new(map))?.0;
                Ok(Value::Object(all.into_iter().map(|(name, Unique(value))| (name, value)).collect()))
            }
        }

        deserializer.deserialize_any(Visitor).map(Unique)
    }
}
