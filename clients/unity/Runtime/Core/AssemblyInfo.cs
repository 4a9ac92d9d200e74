// Lets the tests see what is internal.
using System.Runtime.CompilerServices;

[assembly: InternalsVisibleTo("Tests")]
