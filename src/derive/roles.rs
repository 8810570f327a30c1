//! Attributes of a type that list its fields by role.

use syn::parse::{ParseStream, Parser};
use syn::{Attribute, Data, DeriveInput, Error, Field, Ident, Index, Member, Path, Result, Token};

/// Roles of the fields of a type.
pub struct FieldRoles {
    roles: Vec<(Ident, String)>,
    /// Function that is called last.
    pub then: Option<Path>,
}

impl FieldRoles {
    /// Reads `#[name(role: field, field; role: field; then: function)]`.
    ///
    /// # Errors
    /// A role that is not allowed, or a field that does not exist or is listed twice.
    pub fn read(input: &DeriveInput, name: &str, allowed: &[&str]) -> Result<FieldRoles> {
        let mut roles = FieldRoles { roles: Vec::new(), then: None };
        for attribute in input.attrs.iter().filter(|a| a.path().is_ident(name)) {
            roles.read_attribute(attribute, allowed)?;
        }
        let fields: Vec<_> = fields(input).filter_map(|(_, field)| field.ident.as_ref()).collect();
        for (i, (field, _)) in roles.roles.iter().enumerate() {
            if !fields.contains(&field) {
                return Err(Error::new(field.span(), format!("`{}` has no field `{field}`", input.ident)));
            }
            if roles.roles[..i].iter().any(|(other, _)| other == field) {
                return Err(Error::new(field.span(), format!("the field `{field}` is listed twice")));
            }
        }
        Ok(roles)
    }

    fn read_attribute(&mut self, attribute: &Attribute, allowed: &[&str]) -> Result<()> {
        let parser = |list: ParseStream| {
            while !list.is_empty() {
                let role: Ident = list.parse()?;
                list.parse::<Token![:]>()?;
                if role == "then" && allowed.contains(&"then") {
                    self.then = Some(list.parse()?);
                } else if allowed.iter().any(|name| role == name) {
                    while list.peek(Ident) {
                        self.roles.push((list.parse()?, role.to_string()));
                        list.parse::<Option<Token![,]>>()?;
                    }
                } else {
                    return Err(Error::new(
                        role.span(),
                        format!("unknown role; expected one of {}", allowed.join(", ")),
                    ));
                }
                list.parse::<Option<Token![;]>>()?;
            }
            Ok(())
        };
        parser.parse2(attribute.meta.require_list()?.tokens.clone())
    }

    /// Returns the role of a field; empty for a field that is not listed.
    pub fn of(&self, field: &Field) -> &str {
        let listed = self.roles.iter().find(|(name, _)| field.ident.as_ref() == Some(name));
        listed.map_or("", |(_, role)| role)
    }
}

/// Returns the fields of a struct with their names; none of an enum.
pub fn fields(input: &DeriveInput) -> impl Iterator<Item = (Member, &Field)> {
    let fields = match &input.data {
        Data::Struct(data) => Some(data.fields.iter()),
        _ => None,
    };
    fields.into_iter().flatten().enumerate().map(|(i, field)| {
        let member = field.ident.clone().map_or(Member::Unnamed(Index::from(i)), Member::Named);
        (member, field)
    })
}
