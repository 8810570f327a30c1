//! `#[derive(Memory)]`.

use proc_macro2::TokenStream;
use quote::{quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{DeriveInput, GenericArgument, PathArguments, Result, Type};

use crate::roles::{FieldRoles, fields};

const ROLES: &[&str] = &["uncounted", "flat", "inside"];
const NUMBERS: &[&str] = &["bool", "f32", "f64", "i32", "u8", "u16", "u32", "u64", "usize"];

pub fn expand(input: DeriveInput) -> Result<TokenStream> {
    let roles = FieldRoles::read(&input, "memory", ROLES)?;
    let parts = fields(&input).filter_map(|(name, field)| {
        let value = quote!((&self.#name));
        match roles.of(field) {
            "uncounted" => None,
            "flat" => Some(quote_spanned!(field.ty.span()=> MemoryUse::of(#value))),
            "inside" => owned_inside(&value, &field.ty),
            _ => owned(&value, &field.ty),
        }
    });
    let name = &input.ident;
    let (parameters, arguments, conditions) = input.generics.split_for_impl();
    Ok(quote! {
        impl #parameters ::revolve_numerics::kernel::lists::Memory for #name #arguments #conditions {
            fn memory(&self) -> ::revolve_numerics::kernel::lists::MemoryUse {
                #[allow(unused_imports)] // For types with lists of numbers only.
                use ::revolve_numerics::kernel::lists::{FieldMemory, MemoryUse, MemoryOfCopy as _, MemoryOfOwner as _};
                MemoryUse::default() #(+ #parts)*
            }
        }
    })
}

/// A type whose memory is that of its parts.
enum Composite<'a> {
    List(&'a Type),
    Boxed(&'a Type),
    Optional(&'a Type),
    Array(&'a Type),
    Tuple(Vec<&'a Type>),
}

impl Composite<'_> {
    fn of(ty: &Type) -> Option<Composite<'_>> {
        match ty {
            Type::Array(array) => Some(Composite::Array(&array.elem)),
            Type::Tuple(tuple) => Some(Composite::Tuple(tuple.elems.iter().collect())),
            Type::Path(path) => {
                let last = path.path.segments.last()?;
                let PathArguments::AngleBracketed(arguments) = &last.arguments else { return None };
                let GenericArgument::Type(entry) = arguments.args.first()? else { return None };
                match last.ident.to_string().as_str() {
                    "Vec" => Some(Composite::List(entry)),
                    "Box" => Some(Composite::Boxed(entry)),
                    "Option" => Some(Composite::Optional(entry)),
                    _ => None,
                }
            }
            _ => None,
        }
    }
}

/// Returns the memory that a value owns; `None` for numbers. `value` is an expression of a reference.
fn owned(value: &TokenStream, ty: &Type) -> Option<TokenStream> {
    match Composite::of(ty) {
        Some(Composite::List(_)) => {
            let inside = owned_inside(value, ty).into_iter();
            Some(quote_spanned!(ty.span()=> MemoryUse::of(#value) #(+ #inside)*))
        }
        Some(Composite::Boxed(_)) => {
            let inside = owned_inside(value, ty).into_iter();
            Some(quote!(MemoryUse::in_use(size_of_val(&**#value)) #(+ #inside)*))
        }
        Some(Composite::Optional(content)) => Some(sum(value, owned(&quote!(entry), content)?)),
        Some(_) => owned_inside(value, ty),
        None if NUMBERS.iter().any(|name| matches!(ty, Type::Path(path) if path.path.is_ident(name))) => None,
        None => Some(quote_spanned!(ty.span()=> (&FieldMemory(#value)).memory_of_field())),
    }
}

/// Returns the memory that the entries of a list or the content of a box own.
fn owned_inside(value: &TokenStream, ty: &Type) -> Option<TokenStream> {
    let entry = quote!(entry);
    let of_entry = match Composite::of(ty)? {
        Composite::Boxed(content) => return owned(&quote!((&**#value)), content),
        Composite::Tuple(types) => {
            let parts = types.iter().enumerate().filter_map(|(i, ty)| {
                let i = syn::Index::from(i);
                owned(&quote!((&#value.#i)), ty)
            });
            let parts: Vec<_> = parts.collect();
            return (!parts.is_empty()).then(|| quote!((MemoryUse::default() #(+ #parts)*)));
        }
        Composite::Optional(content) if matches!(Composite::of(content), Some(Composite::Boxed(_))) => {
            owned_inside(&entry, content)
        }
        Composite::List(content) | Composite::Optional(content) | Composite::Array(content) => owned(&entry, content),
    }?;
    Some(sum(value, of_entry))
}

/// Returns the sum over the entries of a list or an option; `of_entry` is an expression of `entry`.
fn sum(value: &TokenStream, of_entry: TokenStream) -> TokenStream {
    quote!(#value.iter().map(|entry| #of_entry).sum::<MemoryUse>())
}
