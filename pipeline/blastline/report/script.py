"""The page's script: sorting and filtering the table of shots. Without it the page lacks nothing but that."""

SCRIPT = """
(function(){
var table=document.getElementById('shots');if(!table)return;
var body=table.tBodies[0],rows=Array.prototype.slice.call(body.rows),heads=table.tHead.rows[0].cells;
Array.prototype.forEach.call(heads,function(head,column){
 var button=document.createElement('button');button.type='button';button.textContent=head.textContent;
 head.textContent='';head.appendChild(button);
 button.addEventListener('click',function(){
  var up=head.getAttribute('aria-sort')!=='ascending';
  Array.prototype.forEach.call(heads,function(other){other.removeAttribute('aria-sort')});
  head.setAttribute('aria-sort',up?'ascending':'descending');
  var number=head.className==='n';
  rows.sort(function(a,b){
   var p=a.cells[column].dataset.v,q=b.cells[column].dataset.v;
   var order=number?parseFloat(p)-parseFloat(q):p.localeCompare(q,undefined,{numeric:true});
   return up?order:-order});
  rows.forEach(function(row){body.appendChild(row)})})});
function of(id){return document.getElementById(id)}
var bar=of('filter'),text=of('find'),only=of('only-failed'),said=of('found');bar.hidden=false;
function filter(){
 var wanted=text.value.trim().toLowerCase(),shown=0;
 rows.forEach(function(row){
  var match=row.textContent.toLowerCase().indexOf(wanted)>=0&&(!only.checked||row.dataset.failed!=='0');
  row.hidden=!match;if(match)shown++});
 said.textContent=shown+' of '+rows.length+' shots'}
text.addEventListener('input',filter);only.addEventListener('change',filter);filter();
})();
"""

FILTER = (
    '<div class="filter" id="filter" hidden><input type="search" id="find" placeholder="Find a shot, timecode, drive"'
    ' aria-label="Find a shot, timecode or drive"><label><input type="checkbox" id="only-failed"> only with failed'
    ' checks</label><span id="found" aria-live="polite"></span></div>'
)
