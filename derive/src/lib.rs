//! `#[derive(Described)]`: from a struct its table of fields, reading, checking and writing; from an enum of structs the
//! choice among them, and from an enum without fields its words. What needs no knowledge of the type is in `lissom::description::schema`, so that little is generated.

use proc_macro2::TokenStream;
use quote::{ToTokens, format_ident, quote};
use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::{Attribute, Data, DeriveInput, Expr, Fields, Ident, Meta, Result, Token, parse_macro_input};

/// An option in `#[part(...)]`. Most are calls of functions with these names: `unit = "m"` is `.unit("m")`.
struct Item(Ident, Option<Expr>);

impl Parse for Item {
    fn parse(input: ParseStream<'_>) -> Result<Self> {
        let name = input.parse()?;
        let value = input.parse::<Option<Token![=]>>()?.map(|_| input.parse()).transpose()?;
        Ok(Self(name, value))
    }
}

impl ToTokens for Item {
    fn to_tokens(&self, tokens: &mut TokenStream) {
        let (name, value) = (&self.0, self.1.iter());
        tokens.extend(quote!(.#name(#(#value)*)));
    }
}

fn items(attributes: &[Attribute]) -> Result<Vec<Item>> {
    let own = attributes.iter().filter(|attribute| attribute.path().is_ident("part"));
    let lists =
        own.map(|attribute| attribute.parse_args_with(Punctuated::<Item, Token![,]>::parse_terminated));
    Ok(lists.collect::<Result<Vec<_>>>()?.into_iter().flatten().collect())
}

/// Takes the option of this name out of others.
fn taken(items: &mut Vec<Item>, name: &str) -> Option<Item> {
    items.iter().position(|item| item.0 == name).map(|i| items.remove(i))
}

/// The doc comment.
fn doc(attributes: &[Attribute]) -> String {
    let lines = attributes.iter().filter_map(|attribute| match &attribute.meta {
        Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
            Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(line), .. }) => Some(line.value()),
            _ => None,
        },
        _ => None,
    });
    lines.map(|line| line.strip_prefix(' ').unwrap_or(&line).to_owned()).collect::<Vec<_>>().join("\n")
}

/// Options of structs are the functions of `schema::Schema`, and `complete = function`, which fills in what was left
/// out, `check = function`, which checks fields against each other, and `derived = function`, which says what follows for a
/// field that is not given. Options of fields are `default`,
/// `default = value`, `key = "name"` where users know another name, and the functions of `schema::Limits`.
#[proc_macro_derive(Described, attributes(part))]
pub fn described(input: proc_macro::TokenStream) -> proc_macro::TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    let made = match &input.data {
        Data::Struct(data) => of_struct(&input, &data.fields),
        Data::Enum(data) if data.variants.iter().all(|one| matches!(one.fields, Fields::Unit)) => {
            Ok(of_words(&input.ident, data.variants.iter().map(|one| &one.ident).collect()))
        }
        Data::Enum(data) => {
            Ok(of_enum(&input.ident, data.variants.iter().map(|one| (&one.ident, &one.fields))))
        }
        Data::Union(_) => Err(syn::Error::new_spanned(&input, "a struct, or an enum of structs")),
    };
    made.unwrap_or_else(|error| error.to_compile_error()).into()
}

fn of_struct(input: &DeriveInput, fields: &Fields) -> Result<TokenStream> {
    let (this, name, text) = (&input.ident, input.ident.to_string(), doc(&input.attrs));
    let mut options = items(&input.attrs)?;
    let complete = taken(&mut options, "complete").map(|item| item.1).into_iter();
    let check = taken(&mut options, "check").map(|item| item.1).into_iter();
    let derived = taken(&mut options, "derived").map(|item| item.1).into_iter();
    let mut table = Vec::new();
    for field in fields {
        let (ty, text) = (&field.ty, doc(&field.attrs));
        let mut limits = items(&field.attrs)?;
        let key = match taken(&mut limits, "key") {
            Some(Item(_, key)) => key.to_token_stream(),
            None => field.ident.as_ref().map(Ident::to_string).to_token_stream(),
        };
        let default = match taken(&mut limits, "default") {
            Some(Item(_, Some(value))) => quote!(Some(|| <#ty as Data>::write(&#value))),
            Some(Item(_, None)) => quote!(Some(|| <#ty as Data>::write(&Default::default()))),
            None => quote!(<#ty as Data>::ABSENT),
        };
        table.push(quote!(Field {
            name: #key, doc: #text, kind: <#ty as Data>::KIND, default: #default, limits: Limits::NONE #(#limits)*
        }));
    }
    let names: Vec<_> = fields.iter().map(|field| &field.ident).collect();
    let types: Vec<_> = fields.iter().map(|field| &field.ty).collect();
    let places: Vec<_> = (0..names.len()).collect();
    let found: Vec<_> = places.iter().map(|i| format_ident!("field_{i}")).collect();
    Ok(quote! { const _: () = {
        use crate::description::schema::{AnyPart, Data, Field, Item, Kind, Limits, Part, Reader, Schema, Value};
        static FIELDS: &[Field] = &[#(#table),*];
        static SCHEMA: Schema = Schema::new(#name, #text, FIELDS, |values, reader| {
            reader.check_given(&SCHEMA, values);
            #this::of_fields(values, reader).map(|part| std::sync::Arc::new(part) as _)
        }) #(#options)*;
        impl #this {
            fn of_fields(values: &[Option<Value>], reader: &mut Reader) -> Option<Self> {
                #(let #found: Option<#types> = reader.field(&FIELDS[#places], values[#places].as_ref());)*
                if ![#(#found.is_some()),*].iter().all(|is_found| *is_found) {
                    #(reader.check(&FIELDS[#places], &#found);)*
                }
                #[allow(unused_mut, reason = "only some are completed")]
                let mut made = Self { #(#names: #found?),* };
                #(#complete(&mut made);)*
                Some(made)
            }
        }
        impl Item for #this {}
        impl Part for #this {
            const SCHEMA: &'static Schema = &SCHEMA;
        }
        impl Data for #this {
            const KIND: Kind = Kind::Part(&SCHEMA);
            fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
                if let Some(same) = value.part::<Self>() { return Some(same.clone()); }
                let values = reader.open(&SCHEMA, value)?;
                Self::of_fields(&values, reader)
            }
            fn check(&self, _: &Limits, reader: &mut Reader) {
                #(reader.check(&FIELDS[#places], &self.#names);)*
                reader.check_needs(self);
                #(#check(self, reader);)*
            }
            fn write(&self) -> Value { Value::Part(std::sync::Arc::new(self.clone())) }
        }
        impl AnyPart for #this {
            fn schema(&self) -> &'static Schema { &SCHEMA }
            fn field(&self, index: usize) -> Value {
                match index { #(#places => self.#names.write(),)* _ => Value::None }
            }
            #(fn derived(&self, index: usize) -> Value { #derived(self, FIELDS[index].name) })*
            fn same(&self, other: &dyn AnyPart) -> bool {
                (other as &dyn std::any::Any).downcast_ref() == Some(self)
            }
            fn check_any(&self, reader: &mut Reader) { self.check(&Limits::NONE, reader); }
        }
    }; })
}

fn of_enum<'a>(this: &Ident, variants: impl Iterator<Item = (&'a Ident, &'a Fields)>) -> TokenStream {
    let (names, types): (Vec<_>, Vec<_>) =
        variants.flat_map(|(name, fields)| fields.iter().map(move |field| (name, &field.ty))).unzip();
    let places = 0..names.len();
    quote! { const _: () = {
        use crate::description::schema::{Data, Item, Kind, Limits, Reader, Value};
        impl Item for #this {}
        #(impl From<#types> for #this { fn from(value: #types) -> Self { Self::#names(value) } })*
        impl Data for #this {
            const KIND: Kind = Kind::OneOf(stringify!(#this), &[#(<#types as Data>::KIND),*]);
            fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
                match reader.choose(&Self::KIND, value)? {
                    #(#places => Data::read(value, reader).map(Self::#names),)*
                    _ => None,
                }
            }
            fn check(&self, limits: &Limits, reader: &mut Reader) {
                match self { #(Self::#names(value) => value.check(limits, reader)),* }
            }
            fn write(&self) -> Value { match self { #(Self::#names(value) => value.write()),* } }
        }
    }; }
}

/// The words of an enum: the names of its variants, in small letters with underscores.
fn of_words(this: &Ident, variants: Vec<&Ident>) -> TokenStream {
    let word = |variant: &&Ident| {
        variant.to_string().chars().enumerate().fold(String::new(), |word, (i, letter)| {
            let between = if i > 0 && letter.is_uppercase() { "_" } else { "" };
            format!("{word}{between}{}", letter.to_lowercase())
        })
    };
    let words: Vec<_> = variants.iter().map(word).collect();
    let places = 0..variants.len();
    quote! { const _: () = {
        use crate::description::schema::{Data, Kind, Limits, Reader, Value};
        impl Data for #this {
            const KIND: Kind = Kind::Word(stringify!(#this), &[#(#words),*]);
            fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
                match reader.word(&Self::KIND, value)? { #(#places => Some(Self::#variants),)* _ => None }
            }
            fn check(&self, _: &Limits, _: &mut Reader) {}
            fn write(&self) -> Value {
                Value::Text(match self { #(Self::#variants => #words),* }.to_owned())
            }
        }
    }; }
}
