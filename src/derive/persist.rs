//! `#[derive(Persist)]`.

use proc_macro2::TokenStream;
use quote::{quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{Data, DeriveInput, Error, Fields, Result, parse_quote};

use crate::roles::{FieldRoles, fields};

const ROLES: &[&str] = &["derived", "fixed", "fixed_lists", "each", "present", "blob", "then"];

pub fn expand(mut input: DeriveInput) -> Result<TokenStream> {
    let roles = FieldRoles::read(&input, "persist", ROLES)?;
    let body = match &input.data {
        Data::Enum(_) => visit_variants(&input)?,
        _ => visit_fields(&input, &roles),
    };
    // Bounds of the declaration imply the trait for the fields; a parameter without bounds is itself state.
    for parameter in input.generics.type_params_mut().filter(|parameter| parameter.bounds.is_empty()) {
        parameter.bounds.push(parse_quote!(::revolve_numerics::state::archive::Persist));
    }
    let name = &input.ident;
    let (parameters, arguments, conditions) = input.generics.split_for_impl();
    Ok(quote! {
        impl #parameters ::revolve_numerics::state::archive::Persist for #name #arguments #conditions {
            #[allow(unused_variables)] // For types without state.
            #[inline]
            fn persist(&mut self, archive: &mut ::revolve_numerics::state::archive::StateArchive<'_>) {
                #body
            }
        }
    })
}

fn visit_fields(input: &DeriveInput, roles: &FieldRoles) -> TokenStream {
    let visits = fields(input).map(|(name, field)| {
        let visit = quote_spanned!(field.ty.span()=> ::revolve_numerics::state::archive::Persist::persist);
        match roles.of(field) {
            "derived" => quote!(),
            "fixed" => quote!(#visit(&mut self.#name[..], archive);),
            "fixed_lists" => quote!(self.#name.iter_mut().for_each(|list| #visit(&mut list[..], archive));),
            "each" => quote! {
                archive.mark(stringify!(#name));
                ::revolve_numerics::state::archive::persist_all(&mut self.#name[..], archive);
            },
            "present" => quote!(if let Some(value) = &mut self.#name { #visit(value, archive); }),
            "blob" => quote!(archive.blob(&mut self.#name);),
            _ => quote!(#visit(&mut self.#name, archive);),
        }
    });
    let then = roles.then.iter();
    quote!(#(#visits)* #(#then(self, archive);)*)
}

/// Visits the number of a variant. Variants with fields are not supported.
fn visit_variants(input: &DeriveInput) -> Result<TokenStream> {
    let Data::Enum(data) = &input.data else { return Ok(quote!()) };
    if let Some(variant) = data.variants.iter().find(|v| !matches!(v.fields, Fields::Unit)) {
        return Err(Error::new(variant.span(), "`Persist` cannot be derived for a variant with fields"));
    }
    let variants: Vec<_> = data.variants.iter().map(|v| &v.ident).collect();
    let numbers: Vec<_> = (0..variants.len() as u8).collect();
    let name = input.ident.to_string();
    Ok(quote! {
        let mut number: u8 = match self { #(Self::#variants => #numbers),* };
        ::revolve_numerics::state::archive::Persist::persist(&mut number, archive);
        match number {
            #(#numbers => *self = Self::#variants,)*
            _ => archive.reject(|| format!("{number} is not a value of {}", #name)),
        }
    })
}
